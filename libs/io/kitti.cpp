#include "io/kitti.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/bytes.hpp"
#include "geodesy/enu_frame.hpp"
#include "io/kitti_text.hpp"

namespace voxatlas {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPointBytes = 16;
constexpr std::size_t kColourBytes = 3;
constexpr std::uintmax_t kMaxTextBytes = std::uintmax_t{1} << 28;  // Two million poses.

/// Bytes of a file from its start, at most `limit`, and how many it has in all.
struct FileBytes {
  Bytes bytes;
  std::uintmax_t size = 0;
};

Result<FileBytes> read_file(const fs::path& path, std::uintmax_t limit) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: no such file", path.string()));
  }
  if (!fs::is_regular_file(path, error)) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: not a regular file", path.string()));
  }
  FileBytes file;
  file.size = fs::file_size(path, error);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(path.c_str(), "rb"),
                                                           &std::fclose);
  if (error || !in) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot be read: {}", path.string(),
                                            error ? error.message() : std::strerror(errno)));
  }
  if (file.size > limit) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} bytes, more than the {} it may have",
                                                    path.string(), file.size, limit));
  }
  file.bytes.resize(static_cast<std::size_t>(file.size));
  const auto got = std::fread(file.bytes.data(), 1, file.bytes.size(), in.get());
  if (std::ferror(in.get()) != 0) {
    return fail(ErrorCode::kIo, fmt::format("{}: {}", path.string(), std::strerror(errno)));
  }
  file.bytes.resize(got);
  return file;
}

/// The number in "000123.bin"; nothing for other names.
std::optional<std::size_t> scan_number(const fs::path& path) {
  const std::string name = path.filename().string();
  std::size_t number = 0;
  const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc{} || name != fmt::format("{:06}.bin", number)) return std::nullopt;
  return number;
}

Result<std::vector<std::size_t>> list_scans(const fs::path& folder) {
  std::error_code error;
  std::vector<std::size_t> numbers;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (const auto number = scan_number(entry->path())) numbers.push_back(*number);
  }
  if (error) {
    const bool missing = error == std::errc::no_such_file_or_directory;
    return fail(missing ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("{}: {}", folder.string(), error.message()));
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

/// Scans 0, 1, 2 ... that are there, up to the first that is not.
std::size_t leading(const std::vector<std::size_t>& numbers) {
  std::size_t count = 0;
  while (count < numbers.size() && numbers[count] == count) ++count;
  return count;
}

fs::path scan_path(const fs::path& folder, const char* kind, std::size_t index) {
  return folder / kind / fmt::format("{:06}.bin", index);
}

/// Keeps the reason that stops the folder at fewer scans than any reason before.
struct Shortest {
  std::size_t count;
  std::optional<Error> reason;

  void limit(std::size_t at, std::string message) {
    if (at >= count && reason) return;
    count = std::min(at, count);
    reason = Error{ErrorCode::kCorrupt, std::move(message)};
  }
};

template <class T>
void limit_by_lines(Shortest& shortest, ParsedLines<T>& lines, const fs::path& file,
                    std::size_t scans) {
  const std::size_t count = lines.entries.size();
  if (lines.ending && count <= scans) {
    shortest.limit(count, std::move(lines.ending->message));
  } else if (count != scans) {
    shortest.limit(std::min(count, scans),
                   fmt::format("{}: {} lines for {} scans", file.string(), count, scans));
  }
}

void take_points(const FileBytes& file, const fs::path& path, KittiScan& out) {
  const std::size_t count = file.bytes.size() / kPointBytes;
  out.scan.points_sensor.resize(count);
  out.scan.intensities.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 4> point;
    std::memcpy(point.data(), file.bytes.data() + i * kPointBytes, kPointBytes);
    out.scan.points_sensor[i] = {point[0], point[1], point[2]};
    out.scan.intensities[i] = point[3];
  }
  if (file.bytes.size() % kPointBytes != 0 || file.bytes.size() != file.size) {
    out.damage = Error{ErrorCode::kCorrupt,
                       fmt::format("{}: ends in the middle: {} bytes, {} whole points of 16 bytes",
                                   path.string(), file.bytes.size(), count)};
  }
}

/// One colour a point, or none at all.
void take_colours(const FileBytes& file, const fs::path& path, KittiScan& out) {
  const std::size_t points = out.scan.points_sensor.size();
  const bool fits = out.damage ? file.bytes.size() >= points * kColourBytes
                               : file.bytes.size() == points * kColourBytes;
  if (!fits) {
    std::string message = fmt::format("{}: {} bytes are not the colours of {} points: left out",
                                      path.string(), file.bytes.size(), points);
    if (out.damage) message = out.damage->message + "; " + message;
    out.damage = Error{ErrorCode::kCorrupt, std::move(message)};
    return;
  }
  out.scan.colours.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    const std::uint8_t* rgb = file.bytes.data() + i * kColourBytes;
    out.scan.colours.push_back({rgb[0], rgb[1], rgb[2]});
  }
}

fs::path find_poses(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  const fs::path inside = folder / name;
  return fs::exists(inside, ignored) || !fs::exists(name, ignored) ? inside : fs::path(name);
}

Result<ParsedLines<std::int64_t>> read_times(const fs::path& path) {
  auto text = read_file(path, kMaxTextBytes);
  if (!text) return pass_on(text);
  return parse_kitti_times(as_text(text->bytes), path.string());
}

Result<ParsedLines<Pose>> read_poses(const fs::path& path, const std::optional<Geodetic>& origin) {
  std::optional<Pose> ecef_from_local;
  if (origin) {
    auto frame = EnuFrame::at(*origin);
    if (!frame) return pass_on(frame);
    ecef_from_local = frame->ecef_from_enu();
  }
  auto text = read_file(path, kMaxTextBytes);
  if (!text) return pass_on(text);
  return parse_kitti_poses(as_text(text->bytes), path.string(), ecef_from_local);
}

}  // namespace

Result<KittiFolder> KittiFolder::open(const fs::path& folder, const KittiOptions& options) {
  auto numbers = list_scans(folder / "velodyne");
  if (!numbers) return pass_on(numbers);
  const fs::path times_path = folder / "times.txt";
  auto times = read_times(times_path);
  if (!times) return pass_on(times);
  const fs::path poses_path = find_poses(folder, options.poses);
  auto poses = read_poses(poses_path, options.origin);
  if (!poses) return pass_on(poses);

  const std::size_t scans = leading(*numbers);
  Shortest shortest{scans, std::nullopt};
  if (scans == 0 || scans < numbers->size()) {
    shortest.limit(scans,
                   fmt::format("{}: missing; the folder has {} scans",
                               scan_path(folder, "velodyne", scans).string(), numbers->size()));
  }
  limit_by_lines(shortest, *times, times_path, scans);
  limit_by_lines(shortest, *poses, poses_path, scans);
  if (shortest.count == 0) return fail(shortest.reason->code, std::move(shortest.reason->message));

  KittiFolder opened;
  opened.folder_ = folder;
  opened.scan_count_ = shortest.count;
  opened.poses_ = std::move(poses->entries);
  opened.utimes_ = std::move(times->entries);
  opened.ending_ = std::move(shortest.reason);
  return opened;
}

Result<KittiScan> KittiFolder::read(std::size_t index) const {
  if (index >= scan_count_) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: scan {} of {}", folder_.string(), index, scan_count_));
  }
  const fs::path path = scan_path(folder_, "velodyne", index);
  auto points = read_file(path, kMaxPoints * kPointBytes);
  if (!points) return pass_on(points);
  KittiScan out;
  out.scan.ecef_from_sensor = poses_[index];
  out.scan.utime = utimes_[index];
  take_points(*points, path, out);

  const fs::path colour_path = scan_path(folder_, "colours", index);
  std::error_code ignored;
  if (fs::exists(colour_path, ignored)) {
    auto colours = read_file(colour_path, kMaxPoints * kColourBytes);
    if (!colours) return pass_on(colours);
    take_colours(*colours, colour_path, out);
  }
  return out;
}

}  // namespace voxatlas
