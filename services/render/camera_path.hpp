#pragma once

#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// Where a camera goes: render_request_t's path, interpolated between its rows (place on a straight
/// line, orientation evenly along the shorter way).
///
/// Errors: create: kInvalid for bytes that are no whole rows; kOutOfRange, naming the row, for
///         seconds that do not start at 0, do not ascend or end after kMaxSeconds, for a row that
///         is no Camera, and for none at all.
/// Cost:   96 bytes a row.
class CameraPath {
 public:
  static constexpr double kMaxSeconds = 3600;

  static Result<CameraPath> create(ByteView rows, const Lens& lens);

  double seconds() const { return rows_.back().seconds; }
  /// How many pictures there are at so many a second; the first is at 0.
  std::int32_t places(double rate) const;
  /// `seconds` off the path is held to its ends.
  Camera at(double seconds) const;

 private:
  struct Row {
    double seconds;
    Eigen::Vector3d position_ecef;
    Eigen::Quaterniond ecef_from_camera;
  };
  CameraPath(std::vector<Row> rows, const Lens& lens) : rows_(std::move(rows)), lens_(lens) {}

  std::vector<Row> rows_;
  Lens lens_;
};

}  // namespace voxatlas
