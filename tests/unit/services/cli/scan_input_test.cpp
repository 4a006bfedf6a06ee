#include "cli/scan_input.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "geodesy/ecef.hpp"
#include "io/kitti_writer.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

namespace fs = std::filesystem;

/// Writes `scans` scans of the simulated drive and returns them.
std::vector<SensorScan> write_drive(const std::string& folder, std::size_t scans) {
  auto simulated = open_simulated({scans, 1}).value();
  auto writer = KittiWriter::create(folder).value();
  std::vector<SensorScan> written;
  for (std::size_t i = 0; i < scans; ++i) {
    written.push_back(simulated.read(i).value().scan);
    REQUIRE(writer.write(written.back()).has_value());
  }
  return written;
}

TEST_CASE("a folder gives the scans that were written into it", "[cli][oracle]") {
  const test::TempDir dir;
  const auto written = write_drive(dir / "drive", 2);

  const auto input = open_kitti({dir / "drive", "poses.txt", ""}).value();

  REQUIRE(input.name == "drive");
  REQUIRE(input.scans == written.size());
  REQUIRE_FALSE(input.ending.has_value());
  for (std::size_t i = 0; i < written.size(); ++i) {
    const auto read = input.read(i).value();
    REQUIRE_FALSE(read.damage.has_value());
    REQUIRE(read.scan.points_sensor == written[i].points_sensor);
    REQUIRE(read.scan.utime == written[i].utime);
  }
}

TEST_CASE("the session stays with the input, however its path is written", "[cli]") {
  const test::TempDir dir;
  write_drive(dir / "drive", 1);
  fs::copy_file(dir / "drive/poses.txt", dir / "drive/other.txt");
  const auto identity = [&](const std::string& folder, const std::string& poses,
                            const std::string& origin = "") {
    return open_kitti({folder, poses, origin}).value().identity;
  };
  const auto plain = identity(dir / "drive", "poses.txt");

  REQUIRE(plain >= 0);  // 63 bits: the wire refuses negative sessions.
  REQUIRE(identity(dir / "drive/", "poses.txt") == plain);
  REQUIRE(identity(dir / "drive/velodyne/..", "poses.txt") == plain);
  REQUIRE(identity(dir / "drive", "other.txt") != plain);
}

TEST_CASE("a drive that broke off gives its whole scans and says why it ends", "[cli]") {
  const test::TempDir dir;
  write_drive(dir / "drive", 3);
  fs::resize_file(dir / "drive/poses.txt", fs::file_size(dir / "drive/poses.txt") - 40);

  const auto input = open_kitti({dir / "drive", "poses.txt", ""}).value();

  REQUIRE(input.scans == 2);
  REQUIRE(input.ending.has_value());
  REQUIRE(input.ending->message.find("poses.txt") != std::string::npos);
}

TEST_CASE("a cut scan is read as far as it is whole, with its damage", "[cli]") {
  const test::TempDir dir;
  const auto written = write_drive(dir / "drive", 1);
  const auto file = dir / "drive/velodyne/000000.bin";
  fs::resize_file(file, fs::file_size(file) - 3);

  const auto read = open_kitti({dir / "drive", "poses.txt", ""}).value().read(0).value();

  REQUIRE(read.scan.points_sensor.size() == written[0].points_sensor.size() - 1);
  REQUIRE(read.damage.has_value());
  REQUIRE(read.damage->message.find("000000.bin") != std::string::npos);
}

TEST_CASE("what cannot be read at all is refused by name", "[cli]") {
  const test::TempDir dir;
  const auto nowhere = open_kitti({dir / "nowhere", "poses.txt", ""});
  REQUIRE_FALSE(nowhere.has_value());
  REQUIRE(nowhere.error().message.find("nowhere") != std::string::npos);
  write_drive(dir / "drive", 1);
  const auto origin = open_kitti({dir / "drive", "poses.txt", "49,8"});
  REQUIRE_FALSE(origin.has_value());
  REQUIRE(origin.error().message.find("--origin 49,8") != std::string::npos);
}

TEST_CASE("the simulated drive is the same for the same seed, and another for another", "[cli]") {
  const auto first = open_simulated({2, 7}).value(), again = open_simulated({2, 7}).value(),
             other = open_simulated({2, 8}).value();
  REQUIRE(first.identity == again.identity);
  REQUIRE(first.identity != other.identity);
  for (const std::size_t i : {1u, 0u}) {  // In any order.
    REQUIRE(first.read(i).value().scan.points_sensor == again.read(i).value().scan.points_sensor);
    REQUIRE(first.read(i).value().scan.points_sensor != other.read(i).value().scan.points_sensor);
  }
}

TEST_CASE("a simulated drive can be elsewhere, faster and sparser, and is then another input",
          "[cli]") {
  const auto here = open_simulated({1, 7}).value(),
             there = open_simulated({1, 7, "-33.9,18.4,20"}).value(),
             fast = open_simulated({1, 7, "", 40}).value(),
             sparse = open_simulated({1, 7, "", 8, 0.8}).value();
  REQUIRE(here.identity != there.identity);
  REQUIRE(here.identity != fast.identity);
  REQUIRE(here.identity != sparse.identity);
  const auto points = here.read(0).value().scan.points_sensor.size();
  const auto half = sparse.read(0).value().scan.points_sensor.size();
  REQUIRE((20 * half > 9 * points && 20 * half < 11 * points));
  const auto place = there.read(0).value().scan.ecef_from_sensor.translation().eval();
  const auto corner = to_ecef({-33.9, 18.4, 20}).value();
  REQUIRE((place - corner).norm() < 600);  // Somewhere in that city.
  REQUIRE_FALSE(open_simulated({1, 7, "nowhere"}).has_value());
  REQUIRE_FALSE(open_simulated({1, 7, "", -1}).has_value());
  REQUIRE_FALSE(open_simulated({1, 7, "", 8, 0}).has_value());
}

}  // namespace
}  // namespace voxatlas
