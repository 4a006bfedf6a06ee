#include "render/camera_message.hpp"

namespace voxatlas {

Result<Camera> to_camera(const camera_t& message) {
  const auto& q = message.orientation;
  Lens lens;
  lens.fx = message.fx;
  lens.fy = message.fy;
  lens.cx = message.cx;
  lens.cy = message.cy;
  lens.width = message.width;
  lens.height = message.height;
  lens.near_range = message.near_range;
  lens.far_range = message.far_range;
  return Camera::create({message.position[0], message.position[1], message.position[2]},
                        Eigen::Quaterniond(q[0], q[1], q[2], q[3]), lens);
}

}  // namespace voxatlas
