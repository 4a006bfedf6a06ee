#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "geodesy/pose.hpp"

namespace voxatlas {

/// What a text file of one entry a line gave.
template <class T>
struct ParsedLines {
  std::vector<T> entries;       ///< The whole entries from the file's start.
  std::optional<Error> ending;  ///< Set where a last line without a line break is no entry: cut.
};

/// times.txt: unix seconds, one a line, rounded to the microsecond.
///
/// Errors: kCorrupt for a line that is not one number, kOutOfRange for a time before 1970 or after
///         the year 5138 (1e11 s), each naming `file`, the line and the value.
[[nodiscard]] Result<ParsedLines<std::int64_t>> parse_kitti_times(std::string_view text,
                                                                  const std::string& file);

/// A pose file: 12 numbers a line, a row-major 3x4 matrix ecef_from_sensor, metres; with
/// `ecef_from_local` given, local_from_sensor.
///
/// Rotations orthonormal to 1e-4 are accepted and made orthonormal.
/// Errors: kCorrupt for lines that are not 12 numbers or no rotation, kOutOfRange for a pose off
/// the
///         Earth (ellipsoidal height outside -12 .. 20 km), each naming `file`, line and value.
[[nodiscard]] Result<ParsedLines<Pose>> parse_kitti_poses(
    std::string_view text, const std::string& file,
    const std::optional<Pose>& ecef_from_local = std::nullopt);

}  // namespace voxatlas
