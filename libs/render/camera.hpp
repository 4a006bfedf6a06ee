#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "base/result.hpp"
#include "grid/grid.hpp"

namespace voxatlas {

enum class Projection {
  kPerspective,   ///< All rays through the camera's position: a pinhole camera.
  kOrthographic,  ///< All rays along the camera's axis: a map.
};

/// How a camera maps what is before it onto pixels.
struct Lens {
  Projection projection = Projection::kPerspective;
  double fx = 0, fy = 0;  ///< Focal lengths, pixels; of an orthographic one pixels a metre.
  double cx = 0, cy = 0;  ///< Principal point, pixels; the middle of pixel (0, 0) is (0.5, 0.5).
  int width = 0, height = 0;
  double near_range = 0.3;   ///< Metres along the axis; nothing nearer is drawn.
  double far_range = 500.0;  ///< Metres along the axis; nothing farther is drawn.

  /// Square pixels, the axis through the middle of the picture.
  static Lens of_view(double vertical_fov_deg, int width, int height);
  /// Orthographic, of a scale; the axis through the middle of the picture.
  static Lens of_map(double pixels_per_metre, int width, int height);
};

/// A camera somewhere on Earth.
///
/// Frame:  the camera's own is x right, y down, z ahead; `ecef_from_camera` turns it to ECEF.
/// Units:  metres, pixels.
/// Errors: create and look_at return kOutOfRange, naming the value, for what is not finite, a
///         position 10 000 km or more from an axis, a quaternion whose length is not 1 to 1 %, a
///         side of the picture outside 1..8192 or more than kMaxPixels in all, a focal length
///         that is not positive, a principal point more than kMaxSide from the picture, for
///         ranges other than 0 < near < far <= 2000, for a perspective picture that opens by more
///         than kMaxSlope (79 degrees from the axis), and for an orthographic one of which
///         anything lies more than kMaxRange from the axis. So bounds() are 20 km wide at most. A
///         camera that exists is valid; it may stand inside the Earth, where there is little to
///         see.
class Camera {
 public:
  static constexpr int kMaxSide = 8192;
  static constexpr std::int64_t kMaxPixels = std::int64_t{1} << 25;
  static constexpr double kMaxRange = 2000;  ///< Metres.
  static constexpr double kMaxSlope = 5;     ///< Metres from the axis, a metre ahead.

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
  bool orthographic() const { return lens_.projection == Projection::kOrthographic; }
  /// Where a point with z > 0 falls, pixels.
  Eigen::Vector2d to_pixel(const Eigen::Vector3d& p_camera) const {
    const double per_z = orthographic() ? 1 : 1 / p_camera.z();
    return {lens_.fx * p_camera.x() * per_z + lens_.cx, lens_.fy * p_camera.y() * per_z + lens_.cy};
  }
  /// Which way the ray through a place of the picture goes, scaled to z = 1,
  Eigen::Vector3d ray(double x_pixel, double y_pixel) const {
    return orthographic() ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(at_one(x_pixel, y_pixel));
  }
  /// and where it is at z, metres; both in the camera's frame.
  Eigen::Vector3d point(double x_pixel, double y_pixel, double z) const {
    const Eigen::Vector3d one = at_one(x_pixel, y_pixel);
    return orthographic() ? Eigen::Vector3d(one.x(), one.y(), z) : Eigen::Vector3d(z * one);
  }

  /// The same view on fewer pixels: each side divided by `divisor`, 1 or more, rounded up.
  Camera shrunk(int divisor) const;
  /// The same view, but the picture's pixels moved by a part of one: for rays beside the middle.
  Camera shifted(double dx_pixel, double dy_pixel) const;

  /// The corners of what is seen, ECEF: four at near_range, then four at far_range.
  std::array<Eigen::Vector3d, 8> corners_ecef() const;
  /// The box around them.
  Box bounds() const;

 private:
  Camera(const Eigen::Vector3d& position, const Eigen::Quaterniond& ecef_from_camera,
         const Lens& lens)
      : position_(position), ecef_from_camera_(ecef_from_camera), lens_(lens) {}

  Eigen::Vector3d at_one(double x_pixel, double y_pixel) const {
    return {(x_pixel - lens_.cx) / lens_.fx, (y_pixel - lens_.cy) / lens_.fy, 1.0};
  }

  Eigen::Vector3d position_;
  Eigen::Quaterniond ecef_from_camera_;
  Lens lens_;
};

}  // namespace voxatlas
