#include "render/gl_view.hpp"

namespace voxatlas {

std::array<double, 16> gl_projection(const Lens& lens, int margin) {
  const double w = lens.width + 2 * margin, h = lens.height + 2 * margin;
  const double n = lens.near_range, f = lens.far_range;
  // GL's y grows upwards, the camera's down.
  const double x = 2 * lens.fx / w, y = -2 * lens.fy / h;
  const double middle_x = 2 * (lens.cx + margin) / w - 1;
  const double middle_y = 1 - 2 * (lens.cy + margin) / h;
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  if (lens.projection == Projection::kOrthographic) {
    m.row(0) << x, 0, 0, middle_x;
    m.row(1) << 0, y, 0, middle_y;
    m.row(2) << 0, 0, 2 / (f - n), -(f + n) / (f - n);
    m.row(3) << 0, 0, 0, 1;
  } else {
    m.row(0) << x, 0, middle_x, 0;
    m.row(1) << 0, y, middle_y, 0;
    m.row(2) << 0, 0, (f + n) / (f - n), -2 * f * n / (f - n);
    m.row(3) << 0, 0, 1, 0;
  }
  std::array<double, 16> columns;
  Eigen::Matrix4d::Map(columns.data()) = m;
  return columns;
}

Eigen::Matrix4d camera_from_tile(const Camera& camera, const Grid& grid, TileKey key, int parts) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = camera.rotation() * (1.0 / grid.cells_per_metre() / parts);
  m.topRightCorner<3, 1>() = camera.to_camera(grid.min_corner(key));
  return m;
}

double gl_depth_of(double metres, const Lens& lens) {
  const double n = lens.near_range, f = lens.far_range;
  if (lens.projection == Projection::kOrthographic) return (metres - n) / (f - n);
  return f * (metres - n) / (metres * (f - n));
}

double metres_of_gl_depth(double depth, const Lens& lens) {
  const double n = lens.near_range, f = lens.far_range;
  if (lens.projection == Projection::kOrthographic) return n + depth * (f - n);
  return f * n / (f - depth * (f - n));
}

}  // namespace voxatlas
