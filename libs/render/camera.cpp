#include "render/camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxatlas {
namespace {

constexpr double kMaxCoordinate = 1e7;
constexpr double kQuaternionTolerance = 0.01;

template <class... Args>
tl::unexpected<Error> refuse(fmt::format_string<Args...> format, Args&&... args) {
  return fail(ErrorCode::kOutOfRange,
              "camera: " + fmt::format(format, std::forward<Args>(args)...));
}

Status check_point(const char* what, const Eigen::Vector3d& p) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(p[axis]) < kMaxCoordinate)) {  // NaN too.
      return refuse("{} has {} = {}, not within 10 000 km of the Earth's centre", what, "xyz"[axis],
                    p[axis]);
    }
  }
  return {};
}

Status check_picture(const Lens& lens) {
  if (lens.width < 1 || lens.width > Camera::kMaxSide || lens.height < 1 ||
      lens.height > Camera::kMaxSide) {
    return refuse("a picture of {} x {} is not within 1..{} on each side", lens.width, lens.height,
                  Camera::kMaxSide);
  }
  if (std::int64_t{lens.width} * lens.height > Camera::kMaxPixels) {
    return refuse("a picture of {} x {} has more than {} pixels", lens.width, lens.height,
                  Camera::kMaxPixels);
  }
  return {};
}

/// How far the picture reaches from the axis: of a map metres, else by metre ahead. Without a limit
/// a tiny focal length would see half of the Earth's tiles.
Status check_reach(const Lens& lens) {
  const double across = std::max(std::abs(lens.cx), std::abs(lens.width - lens.cx)) / lens.fx;
  const double down = std::max(std::abs(lens.cy), std::abs(lens.height - lens.cy)) / lens.fy;
  const double reach = std::max(across, down);
  if (lens.projection == Projection::kOrthographic) {
    if (reach <= Camera::kMaxRange) return {};
    return refuse("a map that reaches {} m from its axis reaches farther than {} m", reach,
                  Camera::kMaxRange);
  }
  if (reach <= Camera::kMaxSlope) return {};
  return refuse("a view that opens {} m from its axis a metre ahead opens more than {} m", reach,
                Camera::kMaxSlope);
}

Status check_lens(const Lens& lens) {
  if (auto picture = check_picture(lens); !picture) return picture;
  constexpr double kMinFocal = 1e-3, kMaxFocal = 1e7;
  for (const double focal : {lens.fx, lens.fy}) {
    if (!(focal >= kMinFocal && focal <= kMaxFocal)) {
      return refuse("a focal length of {} pixels is not within {}..{}", focal, kMinFocal,
                    kMaxFocal);
    }
  }
  if (!(std::abs(lens.cx - lens.width / 2.0) <= Camera::kMaxSide + lens.width / 2.0) ||
      !(std::abs(lens.cy - lens.height / 2.0) <= Camera::kMaxSide + lens.height / 2.0)) {
    return refuse("the principal point ({}, {}) is more than {} pixels off the picture", lens.cx,
                  lens.cy, Camera::kMaxSide);
  }
  constexpr double kMinNear = 1e-3;
  if (!(lens.near_range >= kMinNear && lens.near_range < lens.far_range &&
        lens.far_range <= Camera::kMaxRange)) {
    return refuse("near {} m and far {} m are not {} <= near < far <= {}", lens.near_range,
                  lens.far_range, kMinNear, Camera::kMaxRange);
  }
  return check_reach(lens);
}

}  // namespace

Lens Lens::of_view(double vertical_fov_deg, int width, int height) {
  Lens lens;
  lens.width = width;
  lens.height = height;
  lens.fy = height / 2.0 / std::tan(vertical_fov_deg * std::numbers::pi / 360);
  lens.fx = lens.fy;
  lens.cx = width / 2.0;
  lens.cy = height / 2.0;
  return lens;
}

Lens Lens::of_map(double pixels_per_metre, int width, int height) {
  Lens lens;
  lens.projection = Projection::kOrthographic;
  lens.width = width;
  lens.height = height;
  lens.fx = lens.fy = pixels_per_metre;
  lens.cx = width / 2.0;
  lens.cy = height / 2.0;
  return lens;
}

Result<Camera> Camera::create(const Eigen::Vector3d& position_ecef,
                              const Eigen::Quaterniond& ecef_from_camera, const Lens& lens) {
  if (auto point = check_point("its position", position_ecef); !point) return pass_on(point);
  if (auto good = check_lens(lens); !good) return pass_on(good);
  const double length = ecef_from_camera.norm();
  if (!(std::abs(length - 1) <= kQuaternionTolerance)) {
    return refuse("the orientation (w {}, x {}, y {}, z {}) has length {}, not 1",
                  ecef_from_camera.w(), ecef_from_camera.x(), ecef_from_camera.y(),
                  ecef_from_camera.z(), length);
  }
  return Camera(position_ecef, ecef_from_camera.normalized(), lens);
}

Result<Camera> Camera::look_at(const Eigen::Vector3d& eye_ecef, const Eigen::Vector3d& target_ecef,
                               const Eigen::Vector3d& up_ecef, const Lens& lens) {
  if (auto point = check_point("the eye", eye_ecef); !point) return pass_on(point);
  if (auto point = check_point("the target", target_ecef); !point) return pass_on(point);
  const Eigen::Vector3d sight = target_ecef - eye_ecef;
  if (!(sight.norm() > 1e-6)) {
    return refuse("eye and target are the same point ({}, {}, {})", eye_ecef.x(), eye_ecef.y(),
                  eye_ecef.z());
  }
  if (!(up_ecef.norm() > 1e-6 && up_ecef.norm() < kMaxCoordinate)) {
    return refuse("up ({}, {}, {}) is no direction", up_ecef.x(), up_ecef.y(), up_ecef.z());
  }
  const Eigen::Vector3d ahead = sight.normalized();
  Eigen::Vector3d right = ahead.cross(up_ecef.normalized());
  if (right.norm() < 1e-6) right = ahead.unitOrthogonal();
  right.normalize();
  Eigen::Matrix3d ecef_from_camera;
  ecef_from_camera << right, ahead.cross(right), ahead;
  return create(eye_ecef, Eigen::Quaterniond(ecef_from_camera), lens);
}

Camera Camera::shrunk(int divisor) const {
  Lens lens = lens_;
  lens.width = (lens.width + divisor - 1) / divisor;
  lens.height = (lens.height + divisor - 1) / divisor;
  lens.fx /= divisor;
  lens.fy /= divisor;
  lens.cx /= divisor;
  lens.cy /= divisor;
  return Camera(position_, ecef_from_camera_, lens);
}

Camera Camera::shifted(double dx_pixel, double dy_pixel) const {
  Lens lens = lens_;
  lens.cx -= dx_pixel;
  lens.cy -= dy_pixel;
  return Camera(position_, ecef_from_camera_, lens);
}

std::array<Eigen::Vector3d, 8> Camera::corners_ecef() const {
  std::array<Eigen::Vector3d, 8> corners;
  const Eigen::Matrix3d ecef_from_camera = ecef_from_camera_.toRotationMatrix();
  for (unsigned i = 0; i < corners.size(); ++i) {
    const double z = (i & 4) != 0 ? lens_.far_range : lens_.near_range;
    const double x = (i & 1) != 0 ? lens_.width : 0;
    const double y = (i & 2) != 0 ? lens_.height : 0;
    corners[i] = position_ + ecef_from_camera * point(x, y, z);
  }
  return corners;
}

Box Camera::bounds() const {
  const auto corners = corners_ecef();
  Box box{corners[0], corners[0]};
  for (const auto& corner : corners) {
    box.min = box.min.cwiseMin(corner);
    box.max = box.max.cwiseMax(corner);
  }
  return box;
}

}  // namespace voxatlas
