#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "base/result.hpp"
#include "grid/grid.hpp"

namespace voxatlas {

/// How a pinhole camera maps what is before it onto pixels.
struct Lens {
  double fx = 0, fy = 0;  ///< Focal lengths, pixels.
  double cx = 0, cy = 0;  ///< Principal point, pixels; the middle of pixel (0, 0) is (0.5, 0.5).
  int width = 0, height = 0;
  double near_range = 0.3;   ///< Metres along the axis; nothing nearer is drawn.
  double far_range = 500.0;  ///< Metres along the axis; nothing farther is drawn.

  /// Square pixels, the axis through the middle of the picture.
  static Lens of_view(double vertical_fov_deg, int width, int height);
};

/// A pinhole camera somewhere on Earth.
///
/// Frame:  the camera's own is x right, y down, z ahead; `ecef_from_camera` turns it to ECEF.
/// Units:  metres, pixels.
/// Errors: create and look_at return kOutOfRange, naming the value, for what is not finite, a
///         position 10 000 km or more from an axis, a quaternion whose length is not 1 to 1 %, a
///         side of the picture outside 1..8192 or more than kMaxPixels in all, a focal length
///         that is not positive, a principal point more than kMaxSide from the picture, and for
///         ranges other than 0 < near < far <= 2000. A camera that exists is valid; it may stand
///         inside the Earth, where there is little to see.
class Camera {
 public:
  static constexpr int kMaxSide = 8192;
  static constexpr std::int64_t kMaxPixels = std::int64_t{1} << 25;
  static constexpr double kMaxRange = 2000;

  [[nodiscard]] static Result<Camera> create(const Eigen::Vector3d& position_ecef,
                                             const Eigen::Quaterniond& ecef_from_camera,
                                             const Lens& lens);
  /// Looks from `eye` at `target`, the picture's upright side along `up` as far as that goes;
  /// where `up` is the line of sight itself (straight down), any upright side is taken.
  /// Errors: also where eye and target are the same, or up has no length.
  [[nodiscard]] static Result<Camera> look_at(const Eigen::Vector3d& eye_ecef,
                                              const Eigen::Vector3d& target_ecef,
                                              const Eigen::Vector3d& up_ecef, const Lens& lens);

  const Eigen::Vector3d& position() const { return position_; }
  const Eigen::Quaterniond& orientation() const { return ecef_from_camera_; }
  const Lens& lens() const { return lens_; }
  int width() const { return lens_.width; }
  int height() const { return lens_.height; }

  /// camera_from_ecef, the rotation alone: subtract position() first.
  Eigen::Matrix3d rotation() const { return ecef_from_camera_.conjugate().toRotationMatrix(); }
  Eigen::Vector3d to_camera(const Eigen::Vector3d& p_ecef) const {
    return rotation() * (p_ecef - position_);
  }
  /// Where a point with z > 0 falls, pixels.
  Eigen::Vector2d to_pixel(const Eigen::Vector3d& p_camera) const {
    return {lens_.fx * p_camera.x() / p_camera.z() + lens_.cx,
            lens_.fy * p_camera.y() / p_camera.z() + lens_.cy};
  }
  /// The ray through a place of the picture, scaled to z = 1.
  Eigen::Vector3d ray(double x_pixel, double y_pixel) const {
    return {(x_pixel - lens_.cx) / lens_.fx, (y_pixel - lens_.cy) / lens_.fy, 1.0};
  }

  /// The corners of what is seen, ECEF: four at near_range, then four at far_range.
  std::array<Eigen::Vector3d, 8> corners_ecef() const;
  /// The box around them.
  Box bounds() const;

 private:
  Camera(const Eigen::Vector3d& position, const Eigen::Quaterniond& ecef_from_camera,
         const Lens& lens)
      : position_(position), ecef_from_camera_(ecef_from_camera), lens_(lens) {}

  Eigen::Vector3d position_;
  Eigen::Quaterniond ecef_from_camera_;
  Lens lens_;
};

}  // namespace voxatlas
