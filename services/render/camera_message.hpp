#pragma once

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// The camera a request names. Errors: Camera::create's, for whatever the message holds.
Result<Camera> to_camera(const camera_t& message);

}  // namespace voxatlas
