#pragma once

#include <functional>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "cli/model_client.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// A render_request_t's camera.
camera_t to_message(const Camera& camera);

/// Asks for a picture or a path of them, and hands over each frame, by stream or broadcast, until
/// the last. A request is plain and may be lost, and a renderer may die: where nothing comes for a
/// while it is asked again, a path from where it had come to. A frame that came already is not
/// handed over again.
/// Errors: kUnavailable where nothing comes for `timeout` seconds; kInvalid with what the service
///         says of the request; those of `take`, which end it.
Status ask_for_frames(ModelClient& client, render_request_t request, double timeout,
                      const std::function<Status(const frame_t&)>& take);

}  // namespace voxatlas
