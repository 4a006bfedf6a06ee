#include "io/kitti_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstring>

#include "base/bytes.hpp"

namespace voxatlas {
namespace {

namespace fs = std::filesystem;

/// errno of the write that failed, as an error; `path` is what was being written.
tl::unexpected<Error> write_failed(const fs::path& path) {
  const int reason = errno;
  return fail(reason == ENOSPC ? ErrorCode::kNoSpace : ErrorCode::kIo,
              fmt::format("{}: cannot be written: {}", path.string(),
                          reason == 0 ? "unknown reason" : std::strerror(reason)));
}

Status write_file(const fs::path& path, const Bytes& bytes) {
  errno = 0;
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return write_failed(path);
  return {};
}

Bytes point_bytes(const SensorScan& scan) {
  Bytes bytes;
  bytes.reserve(16 * scan.points_sensor.size());
  ByteWriter writer(bytes);
  for (std::size_t i = 0; i < scan.points_sensor.size(); ++i) {
    for (const float axis : scan.points_sensor[i]) writer.put(axis);
    writer.put(scan.intensities.empty() ? 0.0f : scan.intensities[i]);
  }
  return bytes;
}

Bytes colour_bytes(const SensorScan& scan) {
  Bytes bytes;
  bytes.reserve(3 * scan.colours.size());
  for (const Rgb rgb : scan.colours) bytes.insert(bytes.end(), {rgb.r, rgb.g, rgb.b});
  return bytes;
}

/// Twelve numbers, each the shortest text that reads back as the same double.
std::string pose_line(const Pose& pose) {
  const auto rows = pose.rows();
  return fmt::format("{}", fmt::join(rows, " "));
}

Status check_sizes(const SensorScan& scan) {
  const std::size_t points = scan.points_sensor.size();
  for (const std::size_t size : {scan.intensities.size(), scan.colours.size()}) {
    if (size != 0 && size != points) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("a scan of {} points with {} intensities or colours", points, size));
    }
  }
  return {};
}

}  // namespace

Result<KittiWriter> KittiWriter::create(const fs::path& folder) {
  for (const char* name : {"velodyne", "colours"}) {
    std::error_code error;
    fs::create_directories(folder / name, error);
    if (error) {
      return fail(error == std::errc::no_space_on_device ? ErrorCode::kNoSpace : ErrorCode::kIo,
                  fmt::format("{}: {}", (folder / name).string(), error.message()));
    }
    if (!fs::is_empty(folder / name, error) || error) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: holds scans already; name an empty folder",
                                                   (folder / name).string()));
    }
  }
  KittiWriter writer;
  writer.folder_ = folder;
  writer.times_.open(folder / "times.txt");
  if (!writer.times_) return write_failed(folder / "times.txt");
  writer.poses_.open(folder / "poses.txt");
  if (!writer.poses_) return write_failed(folder / "poses.txt");
  return writer;
}

Status KittiWriter::write(const SensorScan& scan) {
  if (auto sizes = check_sizes(scan); !sizes) return sizes;
  const std::string name = fmt::format("{:06}.bin", written_);
  if (auto points = write_file(folder_ / "velodyne" / name, point_bytes(scan)); !points) {
    return points;
  }
  if (!scan.colours.empty()) {
    if (auto colours = write_file(folder_ / "colours" / name, colour_bytes(scan)); !colours) {
      return colours;
    }
  }
  errno = 0;
  times_ << fmt::format("{}.{:06}\n", scan.utime / 1'000'000, scan.utime % 1'000'000) << std::flush;
  if (!times_) return write_failed(folder_ / "times.txt");
  poses_ << pose_line(scan.ecef_from_sensor) << '\n' << std::flush;
  if (!poses_) return write_failed(folder_ / "poses.txt");
  ++written_;
  return {};
}

}  // namespace voxatlas
