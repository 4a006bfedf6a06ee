#include "bus/convert_scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace voxatlas {

namespace {

constexpr std::size_t kPointBytes = 3 * sizeof(float);
constexpr std::size_t kColourBytes = 3;
constexpr std::size_t kMaxParts = 64;
constexpr std::size_t kMaxPartBytes = 60'000;

Status check_sizes(const scan_t& message) {
  const bool coloured = message.coloured == 1;
  const auto count = static_cast<std::int64_t>(message.count);
  const auto row = static_cast<std::int64_t>(coloured ? kPointBytes + kColourBytes : kPointBytes);
  if (message.coloured < 0 || message.coloured > 1 || count < 0 ||
      count * row != static_cast<std::int64_t>(message.points.size())) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("scan_t: {} points, coloured {}, do not fit {} bytes", message.count,
                            message.coloured, message.points.size()));
  }
  return {};
}

}  // namespace

Result<ScanIdentity> identity_of(const scan_t& message) {
  if (message.source.empty() || message.source.size() > ScanIdentity::kMaxSourceBytes) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("scan_t: source of {} bytes, 1 to {} may be", message.source.size(),
                            ScanIdentity::kMaxSourceBytes));
  }
  if (message.session < 0 || message.seq < 0) {
    return fail(ErrorCode::kOutOfRange, fmt::format("scan_t of {}: session {}, seq {}: negative",
                                                    message.source, message.session, message.seq));
  }
  return ScanIdentity{message.source, message.session, message.seq};
}

Result<SensorScan> to_sensor_scan(const scan_t& message) {
  if (auto sizes = check_sizes(message); !sizes) return pass_on(sizes);
  auto pose = Pose::from_rows(message.ecef_from_sensor);
  if (!pose) return pass_on(pose, "scan_t.ecef_from_sensor");

  const auto count = static_cast<std::size_t>(message.count);
  SensorScan seen;
  seen.ecef_from_sensor = *pose;
  seen.utime = message.utime;
  seen.points_sensor.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3f p_sensor;
    std::memcpy(p_sensor.data(), message.points.data() + i * kPointBytes, kPointBytes);
    seen.points_sensor.push_back(p_sensor);
  }
  if (message.coloured == 1) {
    seen.colours.reserve(count);
    for (const std::uint8_t* at = message.points.data() + count * kPointBytes;
         seen.colours.size() < count; at += kColourBytes) {
      seen.colours.push_back({at[0], at[1], at[2]});
    }
  }
  return seen;
}

Result<Scan> to_scan(const scan_t& message) {
  const auto seen = to_sensor_scan(message);
  if (!seen) return fail(seen.error().code, seen.error().message);
  return to_scan(*seen, message.sigma, message.min_range);
}

scan_t to_message(const SensorScan& scan, const ScanIdentity& identity, double sigma,
                  double min_range) {
  scan_t message{};
  message.utime = scan.utime;
  message.source = identity.source;
  message.session = identity.session;
  message.seq = identity.seq;
  message.part = 0;
  message.parts = 1;
  message.sigma = sigma;
  message.min_range = min_range;
  const auto rows = scan.ecef_from_sensor.rows();
  std::copy(rows.begin(), rows.end(), message.ecef_from_sensor);
  message.coloured = scan.colours.empty() ? 0 : 1;
  message.count = static_cast<std::int32_t>(scan.points_sensor.size());
  const std::size_t xyz_bytes = scan.points_sensor.size() * kPointBytes;
  message.points.resize(xyz_bytes + scan.colours.size() * kColourBytes);
  if (xyz_bytes > 0) std::memcpy(message.points.data(), scan.points_sensor.data(), xyz_bytes);
  std::uint8_t* at = message.points.data() + xyz_bytes;
  for (const Rgb seen : scan.colours) {
    *at++ = seen.r;
    *at++ = seen.g;
    *at++ = seen.b;
  }
  message.size = static_cast<std::int32_t>(message.points.size());
  return message;
}

Result<std::vector<scan_t>> to_parts(const scan_t& whole) {
  if (auto sizes = check_sizes(whole); !sizes) return pass_on(sizes);
  scan_t empty = whole;
  empty.points.clear();
  empty.size = 0;
  const std::size_t row = whole.coloured == 1 ? kPointBytes + kColourBytes : kPointBytes;
  const std::size_t per_part =
      (kMaxPartBytes - static_cast<std::size_t>(empty.getEncodedSize())) / row;
  const auto count = static_cast<std::size_t>(whole.count);
  const std::size_t parts = std::max<std::size_t>(1, (count + per_part - 1) / per_part);
  if (parts > kMaxParts) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("scan {} of {}: {} points need {} parts, {} may be", whole.seq,
                            whole.source, count, parts, kMaxParts));
  }
  std::vector<scan_t> result(parts, empty);
  const std::uint8_t* xyz = whole.points.data();
  const std::uint8_t* rgb = xyz + count * kPointBytes;
  for (std::size_t i = 0; i < parts; ++i) {
    const std::size_t first = i * per_part;
    const std::size_t points = std::min(per_part, count - std::min(count, first));
    auto& part = result[i];
    part.part = static_cast<std::int16_t>(i);
    part.parts = static_cast<std::int16_t>(parts);
    part.count = static_cast<std::int32_t>(points);
    part.points.assign(xyz + first * kPointBytes, xyz + (first + points) * kPointBytes);
    if (whole.coloured == 1) {
      part.points.insert(part.points.end(), rgb + first * kColourBytes,
                         rgb + (first + points) * kColourBytes);
    }
    part.size = static_cast<std::int32_t>(part.points.size());
  }
  return result;
}

}  // namespace voxatlas
