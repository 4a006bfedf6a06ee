#pragma once

#include <vector>

#include "base/result.hpp"
#include "cli/model_client.hpp"
#include "cli/render.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// The camera that the options ask for; the views look at what the model holds.
/// Errors: kInvalid for options that cannot be read; kNotFound, kUnavailable.
Result<Camera> choose_camera(ModelClient& client, const RenderOptions& options);

/// The cameras of a path or an orbit, a picture each. Errors: as above; kIo for the path's file.
Result<std::vector<Camera>> choose_track(ModelClient& client, const RenderOptions& options);

}  // namespace voxatlas
