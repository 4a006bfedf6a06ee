#include "io/kitti_text.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

#include "geodesy/ecef.hpp"
#include "geodesy/enu_frame.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

using Catch::Matchers::Contains;

const char* kMunich = "1 0 0 4177000 0 1 0 855000 0 0 1 4728000\n";

TEST_CASE("times are read to the microsecond", "[io][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::vector<std::int64_t> expected;
  std::string text;
  for (int i = 0; i < 1000; ++i) {
    const auto utime = static_cast<std::int64_t>(rng() % 4'000'000'000'000'000);
    expected.push_back(utime);  // Oracle: the digits were made from integers.
    text += fmt::format("{}.{:06}\n", utime / 1'000'000, utime % 1'000'000);
  }
  const auto times = parse_kitti_times(text, "times.txt");
  REQUIRE(times.has_value());
  REQUIRE(times->entries == expected);
  REQUIRE_FALSE(times->ending.has_value());
}

TEST_CASE("a time that cannot be meant is an error with its line and value", "[io]") {
  const auto word = GENERATE("abc", "1.5x", "nan", "inf", "-1", "1e12", "1e999", "--3");
  const auto times = parse_kitti_times(fmt::format("1.0\n{}\n3.0\n", word), "times.txt");
  REQUIRE_FALSE(times.has_value());
  REQUIRE_THAT(times.error().message, Contains("times.txt: line 2: "));
  if (word != std::string("1e12")) REQUIRE_THAT(times.error().message, Contains(word));
}

TEST_CASE("a pose line is twelve numbers, no more and no fewer", "[io]") {
  for (const char* bad :
       {"1 0 0 4177000\n", "\n", "1 0 0 4177000 0 1 0 855000 0 0 1 4728000 7\n"}) {
    const auto poses = parse_kitti_poses(std::string(kMunich) + bad + kMunich, "poses.txt");
    CAPTURE(bad);
    REQUIRE_FALSE(poses.has_value());
    REQUIRE(poses.error().code == ErrorCode::kCorrupt);
    REQUIRE_THAT(poses.error().message, Contains("poses.txt: line 2: "));
  }
}

TEST_CASE("a text cut anywhere gives its whole lines and says that it was cut", "[io][oracle]") {
  std::string text;
  for (int i = 0; i < 5; ++i) text += kMunich;
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const auto poses = parse_kitti_poses(std::string_view(text).substr(0, size), "poses.txt");
    REQUIRE(poses.has_value());
    const std::size_t line = std::string(kMunich).size();
    const std::size_t over = size % line;
    CAPTURE(size);
    if (over == line - 1) {  // Only the line break is missing: a whole line.
      REQUIRE(poses->entries.size() == size / line + 1);
      REQUIRE_FALSE(poses->ending.has_value());
    } else {
      REQUIRE(poses->entries.size() == size / line);
      REQUIRE(poses->ending.has_value() == (over != 0));
    }
  }
}

TEST_CASE("a pose off the Earth or with a rotation that is none is refused", "[io]") {
  const auto [text, words] = GENERATE(table<const char*, const char*>({
      {"1 0 0 1 0 1 0 2 0 0 1 3\n", "not on the Earth"},
      {"1 0 0 0 0 1 0 0 0 0 1 0\n", "not on the Earth"},
      {"1 0 0 7e6 0 1 0 0 0 0 1 0\n", "7000000"},
      {"1 0 0 nan 0 1 0 855000 0 0 1 4728000\n", "'nan'"},
      {"2 0 0 4177000 0 1 0 855000 0 0 1 4728000\n", "rotation"},
      {"1 0 0 4177000 0 1 0 855000 0 0 -1 4728000\n", "mirror"},
      {"0 0 0 4177000 0 0 0 855000 0 0 0 4728000\n", "rotation"},
  }));
  const auto poses = parse_kitti_poses(text, "poses.txt");
  CAPTURE(text);
  REQUIRE_FALSE(poses.has_value());
  REQUIRE_THAT(poses.error().message, Contains("poses.txt: line 1: ") && Contains(words));
}

TEST_CASE("hostile text shows in a message short and printable", "[io]") {
  const std::string text = std::string(100'000, '\x01') + "\n1\n";
  const auto times = parse_kitti_times(text, "times.txt");
  REQUIRE_FALSE(times.has_value());
  REQUIRE(times.error().message.size() < 120);
  REQUIRE(times.error().message.find('\x01') == std::string::npos);
}

TEST_CASE("local poses stand where their origin is", "[io][oracle]") {
  const Geodetic origin{48.1489, 11.568, 560};
  const auto frame = EnuFrame::at(origin);
  REQUIRE(frame.has_value());
  // 100 m north, looking north: sensor x is north, y is west.
  const auto poses =
      parse_kitti_poses("0 -1 0 0 1 0 0 100 0 0 1 2\n", "poses.txt", frame->ecef_from_enu());
  REQUIRE(poses.has_value());
  const auto place = to_geodetic(poses->entries[0].translation());
  REQUIRE(place.has_value());
  REQUIRE(place->latitude_deg > origin.latitude_deg + 100 / 111'700.0);
  REQUIRE(place->latitude_deg < origin.latitude_deg + 100 / 110'700.0);
  REQUIRE(place->longitude_deg == Approx(origin.longitude_deg).margin(1e-9));
  REQUIRE(place->height == Approx(562).margin(2e-3));
  const Eigen::Vector3d ahead_ecef = poses->entries[0].rotation().col(0);
  REQUIRE((ahead_ecef - frame->north_ecef()).norm() < 1e-12);
}

}  // namespace
}  // namespace voxatlas
