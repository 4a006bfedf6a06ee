#include "bus/bot_core.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <bot_core/pointcloud_t.hpp>
#include <bot_core/pose_t.hpp>
#include <cmath>

#include "bus/wire.hpp"

namespace voxatlas {
namespace {

/// LCM's numbers, which are big endian. A read past the end fails for good, as ByteReader's do.
class WireReader {
 public:
  explicit WireReader(ByteView in) : in_(in) {}

  template <class T>
  T get() {
    using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
    const ByteView raw = in_.get_bytes(sizeof(T));
    Bits bits = 0;
    for (const std::uint8_t byte : raw) bits = bits << 8 | byte;
    return std::bit_cast<T>(bits);
  }

  /// A count of things that take at least so many bytes each: never more than can follow.
  std::size_t get_count(std::size_t bytes_each) {
    const auto count = get<std::int32_t>();
    if (count < 0 || static_cast<std::size_t>(count) > in_.remaining() / bytes_each) {
      in_.get_bytes(UINT64_MAX);
      return 0;
    }
    return static_cast<std::size_t>(count);
  }

  std::string get_string() {
    const ByteView text = in_.get_bytes(get_count(1));
    if (text.empty() || text.back() != 0) {
      in_.get_bytes(UINT64_MAX);
      return {};
    }
    return std::string(as_text(text.first(text.size() - 1)));
  }

  ByteView get_bytes(std::size_t count) { return in_.get_bytes(count); }
  bool ok() const { return in_.ok(); }
  bool at_end() const { return in_.at_end(); }
  std::size_t position() const { return in_.position(); }

 private:
  ByteReader in_;
};

float float_at(ByteView bytes, std::size_t index) {
  const std::uint8_t* at = bytes.data() + 4 * index;
  return std::bit_cast<float>(std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 |
                              std::uint32_t{at[2]} << 8 | std::uint32_t{at[3]});
}

/// The colours of three channels, each a number from 0 to 1 a point.
Result<std::vector<Rgb>> read_colours(const std::array<ByteView, 3>& channels, std::size_t count) {
  std::vector<Rgb> colours(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = float_at(channels[c], i);
      if (!(value >= 0 && value <= 1)) {
        return fail(ErrorCode::kOutOfRange,
                    fmt::format("channel {} of point {} is {}, colours are 0 to 1; the points are "
                                "taken without colours",
                                "rgb"[c], i, value));
      }
      rgb[c] = static_cast<std::uint8_t>(std::lround(value * 255));
    }
    colours[i] = {rgb[0], rgb[1], rgb[2]};
  }
  return colours;
}

}  // namespace

LoggedType logged_type(ByteView message) {
  const auto fingerprint = WireReader(message).get<std::int64_t>();
  if (message.size() < sizeof fingerprint) return LoggedType::kOther;
  if (fingerprint == scan_t::getHash()) return LoggedType::kScan;
  if (fingerprint == bot_core::pointcloud_t::getHash()) return LoggedType::kPointCloud;
  if (fingerprint == bot_core::pose_t::getHash()) return LoggedType::kPose;
  return LoggedType::kOther;
}

Result<BotPointCloud> decode_point_cloud(ByteView message) {
  constexpr std::size_t kPointBytes = 12, kLeastNameBytes = 5;
  WireReader reader(message);
  BotPointCloud cloud;
  const bool is_cloud = reader.get<std::int64_t>() == bot_core::pointcloud_t::getHash();
  cloud.utime = reader.get<std::int64_t>();
  reader.get<std::int32_t>();  // seq
  cloud.frame_id = reader.get_string();
  const std::size_t count = reader.get_count(kPointBytes);
  const ByteView xyz = reader.get_bytes(count * kPointBytes);
  std::vector<std::string> names(reader.get_count(kLeastNameBytes));
  for (auto& name : names) name = reader.get_string();
  std::array<ByteView, 3> rgb;
  std::array<bool, 3> has{};
  for (const auto& name : names) {
    const ByteView channel = reader.get_bytes(4 * count);
    const auto colour = name.size() == 1 ? std::string_view("rgb").find(name) : std::string::npos;
    if (colour == std::string::npos) continue;
    rgb[colour] = channel;
    has[colour] = true;
  }
  if (!is_cloud || !reader.at_end()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("no bot_core.pointcloud_t: {} bytes make no sense from byte {} on",
                            message.size(), reader.position()));
  }
  cloud.points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.emplace_back(float_at(xyz, 3 * i), float_at(xyz, 3 * i + 1),
                              float_at(xyz, 3 * i + 2));
  }
  if (has[0] && has[1] && has[2]) {
    auto colours = read_colours(rgb, count);
    if (colours) cloud.colours = std::move(*colours);
    if (!colours) cloud.colour_problem = colours.error();
  }
  return cloud;
}

Result<BotPose> decode_bot_pose(ByteView message) {
  bot_core::pose_t pose{};
  const auto size = static_cast<int>(message.size());
  if (pose.decode(message.data(), 0, size) != size) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("no bot_core.pose_t: {} bytes make no sense", message.size()));
  }
  const double* q = pose.orientation;
  auto placed =
      Pose::from_quaternion(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), Eigen::Vector3d(pose.pos));
  if (!placed) return pass_on(placed, fmt::format("bot_core.pose_t of utime {}", pose.utime));
  return BotPose{pose.utime, *placed};
}

}  // namespace voxatlas
