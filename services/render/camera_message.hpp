#pragma once

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// The camera a request names. Errors: Camera::create's, for whatever the message holds, and
/// kOutOfRange for a projection that is none.
Result<Camera> to_camera(const camera_t& message);
/// Its lens alone, unchecked but for the projection: 1 is orthographic, all else is not.
Lens lens_of(const camera_t& message);

camera_t to_message(const Camera& camera);

}  // namespace voxatlas
