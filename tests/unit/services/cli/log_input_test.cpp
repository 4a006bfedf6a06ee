#include "cli/log_input.hpp"

#include <bot_core/pointcloud_t.hpp>
#include <bot_core/pose_t.hpp>
#include <catch2/catch.hpp>
#include <fstream>

#include "bus/convert_scan.hpp"
#include "bus/wire.hpp"
#include "geodesy/enu_frame.hpp"
#include "io/kitti_writer.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

constexpr const char* kOrigin = "48.1,11.5,500";

/// A log as lcm-logger writes it, byte by byte.
class LogWriter {
 public:
  explicit LogWriter(const std::string& path) : out_(path, std::ios::binary) {}

  template <class T>
  void add(const std::string& channel, const T& message) {
    add_bytes(channel, encode_message(message));
  }
  void add_bytes(const std::string& channel, const Bytes& data) {
    put(0xeda1da01, 4);
    put(number_++, 8);
    put(1'700'000'000'000'000, 8);
    put(channel.size(), 4);
    put(data.size(), 4);
    out_ << channel << as_text(data) << std::flush;
  }

 private:
  void put(std::uint64_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) out_.put(static_cast<char>(value >> 8 * i));
  }
  std::ofstream out_;
  std::uint64_t number_ = 0;
};

bot_core::pose_t make_pose(std::int64_t utime, double east) {
  bot_core::pose_t pose{};
  pose.utime = utime;
  pose.pos[0] = east;
  pose.orientation[0] = 1;
  return pose;
}

bot_core::pointcloud_t make_cloud(std::int64_t utime) {
  bot_core::pointcloud_t cloud{};
  cloud.utime = utime;
  cloud.n_points = 2;
  cloud.points = {{1, 2, 3}, {4, 5, 6}};
  return cloud;
}

/// What `publish` would send of an input, all of it.
std::vector<Bytes> messages_of(ScanInput& input) {
  std::vector<Bytes> messages;
  for (std::size_t i = 0; i < input.scans; ++i) {
    const auto read = input.read(i).value();
    REQUIRE_FALSE(read.damage.has_value());
    messages.push_back(encode_message(
        to_message(read.scan, {"car", 1, static_cast<std::int64_t>(i)},
                   read.sigma.value_or(input.sigma), read.min_range.value_or(input.min_range))));
  }
  return messages;
}

TEST_CASE("a log of a folder's scans gives what the folder gives, bit for bit", "[cli][oracle]") {
  const test::TempDir dir;
  {
    auto simulated = open_simulated({3, 1}).value();
    auto writer = KittiWriter::create(dir / "drive").value();
    for (std::size_t i = 0; i < 3; ++i) {
      REQUIRE(writer.write(simulated.read(i).value().scan).has_value());
    }
  }
  auto folder = open_kitti({dir / "drive", "poses.txt", ""}).value();
  LogWriter whole(dir / "whole.lcm"), cut(dir / "parts.lcm");
  for (std::int64_t i = 0; i < 3; ++i) {
    const auto scan = folder.read(static_cast<std::size_t>(i)).value().scan;
    const auto message = to_message(scan, {"car", 9, i}, folder.sigma, folder.min_range);
    whole.add("VOXATLAS_SCAN", message);
    auto parts = to_parts(message).value();
    REQUIRE(parts.size() > 1);
    std::ranges::reverse(parts);  // A datagram may overtake another,
    for (const auto& part : parts) {
      cut.add("VOXATLAS_SCAN", part);
      cut.add("VOXATLAS_SCAN", part);       // and be heard twice,
      cut.add("VOXATLAS_STATUS", ack_t{});  // among others.
    }
  }

  auto from_whole = open_log({dir / "whole.lcm", "", "", ""}).value();
  auto from_parts = open_log({dir / "parts.lcm", "", "", ""}).value();

  const auto expected = messages_of(folder);
  REQUIRE(messages_of(from_whole) == expected);
  REQUIRE(messages_of(from_parts) == expected);
  REQUIRE_FALSE(from_whole.ending.has_value());
  REQUIRE_FALSE(from_parts.ending.has_value());
  REQUIRE(from_whole.name == "whole");
  REQUIRE(from_whole.identity >= 0);
  REQUIRE(from_whole.identity != from_parts.identity);
}

TEST_CASE("a scan that lacks a part is left out, and it is told", "[cli][hostile]") {
  const test::TempDir dir;
  auto simulated = open_simulated({2, 1}).value();
  LogWriter log(dir / "log.lcm");
  for (std::int64_t i = 0; i < 2; ++i) {
    const auto scan = simulated.read(static_cast<std::size_t>(i)).value().scan;
    auto parts = to_parts(to_message(scan, {"car", 9, i}, 0.02, 0)).value();
    if (i == 0) parts.erase(parts.begin() + 1);
    for (const auto& part : parts) log.add("SCAN", part);
  }

  const auto input = open_log({dir / "log.lcm", "", "", ""}).value();

  REQUIRE(input.scans == 1);
  REQUIRE(input.ending->code == ErrorCode::kCorrupt);
  REQUIRE(input.read(0).value().scan.utime == simulated.read(1).value().scan.utime);
}

TEST_CASE("a log cut off gives its whole scans and says why it ends", "[cli][hostile]") {
  const test::TempDir dir;
  auto simulated = open_simulated({2, 1}).value();
  {
    LogWriter log(dir / "log.lcm");
    for (std::int64_t i = 0; i < 2; ++i) {
      const auto scan = simulated.read(static_cast<std::size_t>(i)).value().scan;
      log.add("SCAN", to_message(scan, {"car", 9, i}, 0.02, 0));
    }
  }
  std::filesystem::resize_file(dir / "log.lcm", std::filesystem::file_size(dir / "log.lcm") - 5);

  const auto input = open_log({dir / "log.lcm", "", "", ""}).value();

  REQUIRE(input.scans == 1);
  REQUIRE(input.ending->code == ErrorCode::kCorrupt);
  REQUIRE(input.read(0).value().scan.points_sensor == simulated.read(0).value().scan.points_sensor);
}

TEST_CASE("a cloud is placed where its body was at its time", "[cli][oracle]") {
  const test::TempDir dir;
  LogWriter log(dir / "log.lcm");
  log.add("POSE", make_pose(1'000'000, 10));
  log.add("CLOUD", make_cloud(1'250'000));
  log.add("CLOUD", make_cloud(9'000'000));    // Nobody knows where.
  log.add("POSE", make_pose(1'500'000, 20));  // Later than the cloud it places.

  auto input = open_log({dir / "log.lcm", kOrigin, "", ""}).value();

  REQUIRE(input.scans == 1);
  REQUIRE(input.ending->code == ErrorCode::kOutOfRange);
  const auto scan = input.read(0).value().scan;
  REQUIRE(scan.utime == 1'250'000);
  REQUIRE(scan.points_sensor ==
          std::vector<Eigen::Vector3f>{Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 5, 6)});
  const auto frame = EnuFrame::at(Geodetic{48.1, 11.5, 500}).value();
  const Eigen::Vector3d place = frame.ecef_from_enu() * Eigen::Vector3d(15, 0, 0);
  REQUIRE((scan.ecef_from_sensor.translation() - place).norm() < 1e-6);
}

TEST_CASE("channels are chosen, never guessed", "[cli]") {
  const test::TempDir dir;
  {
    LogWriter log(dir / "log.lcm");
    log.add("POSE_A", make_pose(0, 10));
    log.add("POSE_B", make_pose(0, 20));
    log.add("FRONT", make_cloud(0));
    log.add("REAR", make_cloud(0));
    LogWriter bare(dir / "bare.lcm");
    bare.add("FRONT", make_cloud(0));
  }
  const auto open = [&](const std::string& name, const std::string& cloud,
                        const std::string& pose) {
    return open_log({dir / name, kOrigin, cloud, pose});
  };

  REQUIRE(open("log.lcm", "", "").error().code == ErrorCode::kInvalid);
  REQUIRE(open("log.lcm", "", "").error().message.find("POSE_A and POSE_B") != std::string::npos);
  REQUIRE(open("log.lcm", "", "POSE_C").error().code == ErrorCode::kInvalid);
  REQUIRE(open("bare.lcm", "", "").error().code == ErrorCode::kInvalid);
  REQUIRE(open("log.lcm", "", "POSE_B")->scans == 2);
  REQUIRE(open("log.lcm", "REAR", "POSE_B")->scans == 1);
  REQUIRE(open("log.lcm", "NONE", "POSE_B").error().code == ErrorCode::kNotFound);
  REQUIRE(open("log.lcm", "", "POSE_A")->identity != open("log.lcm", "", "POSE_B")->identity);
}

TEST_CASE("a log without scans, or of damage alone, is refused", "[cli][hostile]") {
  const test::TempDir dir;
  {
    LogWriter log(dir / "other.lcm");
    log.add("VOXATLAS_ACK", ack_t{});
    LogWriter damaged(dir / "damaged.lcm");
    Bytes scan = encode_message(to_message(SensorScan{}, {"car", 9, 0}, 0.02, 0));
    scan.pop_back();
    damaged.add_bytes("SCAN", scan);
    const std::ofstream empty(dir / "empty.lcm");
  }
  const auto code = [&](const std::string& name) {
    return open_log({dir / name, "", "", ""}).error().code;
  };

  REQUIRE(code("other.lcm") == ErrorCode::kNotFound);
  REQUIRE(code("empty.lcm") == ErrorCode::kNotFound);
  REQUIRE(code("nowhere.lcm") == ErrorCode::kNotFound);
  REQUIRE(code("damaged.lcm") == ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace voxatlas
