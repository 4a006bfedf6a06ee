#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>

#include "base/result.hpp"
#include "integrate/sensor_scan.hpp"

namespace voxatlas {

/// Writes scans as a folder that KittiFolder reads: ecef_from_sensor poses, colours where a scan
/// has them. Poses and times keep every digit, so what is read back is what was written.
///
/// Order:  a scan's points stand on disk before its lines in times.txt and poses.txt do: killed in
///         the middle, the folder holds the whole scans written so far.
/// Errors: kInvalid where the folder holds scans already, or a scan contradicts itself; kNoSpace;
///         kIo.
class KittiWriter {
 public:
  [[nodiscard]] static Result<KittiWriter> create(const std::filesystem::path& folder);

  [[nodiscard]] Status write(const SensorScan& scan);
  std::size_t written() const { return written_; }

 private:
  std::filesystem::path folder_;
  std::ofstream times_;
  std::ofstream poses_;
  std::size_t written_ = 0;
};

}  // namespace voxatlas
