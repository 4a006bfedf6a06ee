#include "render/camera_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace voxatlas {

Lens lens_of(const camera_t& message) {
  Lens lens;
  lens.projection = message.projection == 1 ? Projection::kOrthographic : Projection::kPerspective;
  lens.fx = message.fx;
  lens.fy = message.fy;
  lens.cx = message.cx;
  lens.cy = message.cy;
  lens.width = message.width;
  lens.height = message.height;
  lens.near_range = message.near_range;
  lens.far_range = message.far_range;
  return lens;
}

Result<Camera> to_camera(const camera_t& message) {
  if (message.projection != 0 && message.projection != 1) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("camera: projection {} is neither 0 (pinhole) nor 1 (orthographic)",
                            message.projection));
  }
  const auto& q = message.orientation;
  return Camera::create({message.position[0], message.position[1], message.position[2]},
                        Eigen::Quaterniond(q[0], q[1], q[2], q[3]), lens_of(message));
}

camera_t to_message(const Camera& camera) {
  camera_t message{};
  const Lens& lens = camera.lens();
  message.projection = camera.orthographic() ? 1 : 0;
  for (int axis = 0; axis < 3; ++axis) message.position[axis] = camera.position()[axis];
  const auto& turn = camera.orientation();
  const double wxyz[] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy(std::begin(wxyz), std::end(wxyz), message.orientation);
  message.fx = lens.fx;
  message.fy = lens.fy;
  message.cx = lens.cx;
  message.cy = lens.cy;
  message.width = lens.width;
  message.height = lens.height;
  message.near_range = lens.near_range;
  message.far_range = lens.far_range;
  return message;
}

}  // namespace voxatlas
