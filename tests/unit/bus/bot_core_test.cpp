#include "bus/bot_core.hpp"

#include <bot_core/pointcloud_t.hpp>
#include <bot_core/pose_t.hpp>
#include <catch2/catch.hpp>
#include <limits>

#include "bus/wire.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Written by lcm-gen's encoder: the oracle of the reader that does without its decoder.
bot_core::pointcloud_t make_cloud(std::size_t points, const std::vector<std::string>& channels,
                                  std::mt19937_64& rng) {
  std::uniform_real_distribution<float> metres(-80, 80), part(0, 1);
  bot_core::pointcloud_t cloud{};
  cloud.utime = static_cast<std::int64_t>(rng() >> 2);
  cloud.seq = 7;
  cloud.frame_id = "body";
  cloud.n_points = static_cast<std::int32_t>(points);
  for (std::size_t i = 0; i < points; ++i) {
    cloud.points.push_back({metres(rng), metres(rng), metres(rng)});
  }
  cloud.n_channels = static_cast<std::int32_t>(channels.size());
  cloud.channel_names = channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    auto& values = cloud.channels.emplace_back();
    for (std::size_t i = 0; i < points; ++i) values.push_back(part(rng));
  }
  return cloud;
}

bot_core::pose_t make_pose() {
  bot_core::pose_t pose{};
  pose.utime = 5;
  pose.pos[0] = 1;
  pose.pos[1] = -2;
  pose.pos[2] = 3;
  pose.orientation[0] = 0.5;  // A third of a turn about the diagonal: x to y to z to x.
  pose.orientation[1] = pose.orientation[2] = pose.orientation[3] = 0.5;
  return pose;
}

TEST_CASE("a point cloud is read as its encoder wrote it", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 50; ++round) {
    const std::vector<std::string> channels = {"b", "intensity", "r", "g"};
    const auto sent = make_cloud(rng() % 300, channels, rng);

    const auto got = decode_point_cloud(encode_message(sent)).value();

    REQUIRE(got.utime == sent.utime);
    REQUIRE(got.frame_id == sent.frame_id);
    REQUIRE(got.points.size() == sent.points.size());
    REQUIRE(got.colours.size() == sent.points.size());
    REQUIRE_FALSE(got.colour_problem.has_value());
    for (std::size_t i = 0; i < sent.points.size(); ++i) {
      REQUIRE(got.points[i] == Eigen::Vector3f(sent.points[i].data()));
      const auto byte = [&](std::size_t c) {
        return static_cast<std::uint8_t>(sent.channels[c][i] * 255 + 0.5F);
      };
      REQUIRE(got.colours[i] == Rgb{byte(2), byte(3), byte(0)});
    }
  }
}

TEST_CASE("a cloud without all three colours has none", "[bus]") {
  auto rng = test::engine();
  const auto got = decode_point_cloud(encode_message(make_cloud(5, {"r", "g"}, rng))).value();
  REQUIRE(got.points.size() == 5);
  REQUIRE(got.colours.empty());
  REQUIRE_FALSE(got.colour_problem.has_value());
}

TEST_CASE("a cloud's colours beyond 0 to 1 are left out, and it is told", "[bus]") {
  auto rng = test::engine();
  for (const float wrong : {255.0F, -0.1F, std::numeric_limits<float>::quiet_NaN()}) {
    auto sent = make_cloud(5, {"r", "g", "b"}, rng);
    sent.channels[1][3] = wrong;
    const auto got = decode_point_cloud(encode_message(sent)).value();
    REQUIRE(got.points.size() == 5);
    REQUIRE(got.colours.empty());
    REQUIRE(got.colour_problem->code == ErrorCode::kOutOfRange);
  }
}

TEST_CASE("a damaged cloud is refused, whatever its lengths say", "[bus][hostile]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Bytes whole = encode_message(make_cloud(20, {"r", "g", "b"}, rng));
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    REQUIRE(decode_point_cloud(ByteView(whole).first(cut)).error().code == ErrorCode::kCorrupt);
  }
  Bytes longer = whole;
  longer.push_back(0);
  REQUIRE_FALSE(decode_point_cloud(longer).has_value());
  for (int round = 0; round < 20'000; ++round) {
    Bytes hit = whole;
    hit[rng() % hit.size()] = static_cast<std::uint8_t>(rng());
    const auto got = decode_point_cloud(hit);
    if (got) REQUIRE(12 * got->points.size() <= hit.size());
  }
  REQUIRE_FALSE(decode_point_cloud(encode_message(make_pose())).has_value());
}

TEST_CASE("a pose is read with w before x, y and z", "[bus]") {
  const auto got = decode_bot_pose(encode_message(make_pose())).value();
  REQUIRE(got.utime == 5);
  REQUIRE((got.local_from_body * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, -1, 3)).norm() <
          1e-12);
}

TEST_CASE("a pose that is none is refused", "[bus][hostile]") {
  auto crooked = make_pose();
  crooked.orientation[0] = 2;
  REQUIRE(decode_bot_pose(encode_message(crooked)).error().code == ErrorCode::kInvalid);
  auto nowhere = make_pose();
  nowhere.pos[1] = std::numeric_limits<double>::infinity();
  REQUIRE(decode_bot_pose(encode_message(nowhere)).error().code == ErrorCode::kOutOfRange);
  const Bytes whole = encode_message(make_pose());
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    REQUIRE(decode_bot_pose(ByteView(whole).first(cut)).error().code == ErrorCode::kCorrupt);
  }
  Bytes other = whole;
  other[0] ^= 1;
  REQUIRE(decode_bot_pose(other).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("what a message is, its fingerprint says", "[bus]") {
  auto rng = test::engine();
  REQUIRE(logged_type(encode_message(make_pose())) == LoggedType::kPose);
  REQUIRE(logged_type(encode_message(make_cloud(1, {}, rng))) == LoggedType::kPointCloud);
  scan_t scan{};
  REQUIRE(logged_type(encode_message(scan)) == LoggedType::kScan);
  REQUIRE(logged_type(encode_message(ack_t{})) == LoggedType::kOther);
  const Bytes pose = encode_message(make_pose());
  REQUIRE(logged_type(ByteView(pose).first(7)) == LoggedType::kOther);
  REQUIRE(logged_type({}) == LoggedType::kOther);
}

}  // namespace
}  // namespace voxatlas
