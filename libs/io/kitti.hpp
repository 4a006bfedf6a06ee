#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "geodesy/pose.hpp"
#include "integrate/sensor_scan.hpp"

namespace voxatlas {

struct KittiOptions {
  std::string poses = "poses.txt";  ///< Looked up in the folder first, then as a path.
  /// Where the poses' local frame stands: it is read as east, north, up at this place. Unset: the
  /// poses are ecef_from_sensor. (KITTI's own odometry poses have x right, y down, z forward; turn
  /// them to east, north, up before.)
  std::optional<Geodetic> origin;
};

/// One scan out of a folder; where its files end in the middle, what is whole and what is wrong.
struct KittiScan {
  SensorScan scan;
  std::optional<Error> damage;
};

/// A folder of scans in KITTI odometry form:
///
///     velodyne/NNNNNN.bin   float32 x y z intensity a point, little endian, sensor frame
///     colours/NNNNNN.bin    optional: three bytes a point, red green blue
///     times.txt             unix seconds, one line a scan
///     poses.txt             twelve numbers a line: row-major 3x4 ecef_from_sensor
///
/// Damage:  what ends in the middle gives its whole part: read() the scan_count() scans, then
/// report
///          ending(). A pose file of 37 and a half lines for 40 scans gives 37 scans and an ending.
/// Errors:  name the file, the line or byte count, and the value. NaN points are kept.
/// Memory:  the poses and times of the folder; one scan while it is read, as large as its file.
/// Threads: read() from any number of threads.
class KittiFolder {
 public:
  static constexpr std::size_t kMaxPoints = std::size_t{1} << 24;  ///< A scan; more is refused.

  /// Errors: kNotFound, kIo; kCorrupt and kOutOfRange for text that cannot be meant; all of them
  ///         where not a single scan is whole.
  [[nodiscard]] static Result<KittiFolder> open(const std::filesystem::path& folder,
                                                const KittiOptions& options);

  /// Scans that have points, a time and a pose.
  std::size_t scan_count() const { return scan_count_; }
  const Pose& ecef_from_sensor(std::size_t index) const { return poses_[index]; }
  std::int64_t utime(std::size_t index) const { return utimes_[index]; }

  /// Why there are no more scans than scan_count(), although some file promises more.
  const std::optional<Error>& ending() const { return ending_; }

  /// Errors: kOutOfRange for index >= scan_count() and for files above kMaxPoints; kIo. A file
  /// whose
  ///         size is not whole points gives those that are, and `damage`.
  [[nodiscard]] Result<KittiScan> read(std::size_t index) const;

 private:
  std::filesystem::path folder_;
  std::size_t scan_count_ = 0;
  std::vector<Pose> poses_;
  std::vector<std::int64_t> utimes_;
  std::optional<Error> ending_;
};

}  // namespace voxatlas
