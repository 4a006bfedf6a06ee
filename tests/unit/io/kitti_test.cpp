#include "io/kitti.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/kitti_writer.hpp"
#include "support/engine.hpp"
#include "temporary_folder.hpp"

namespace voxatlas {
namespace {

using Catch::Matchers::Contains;
using test::TemporaryFolder;

SensorScan any_scan(std::mt19937_64& rng, std::size_t points, bool coloured) {
  std::normal_distribution<float> metres(0, 30);
  SensorScan scan;
  for (std::size_t i = 0; i < points; ++i) {
    scan.points_sensor.emplace_back(metres(rng), metres(rng), metres(rng));
    scan.intensities.push_back(static_cast<float>(rng() % 256) / 255);
    if (coloured) {
      scan.colours.push_back({static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng()),
                              static_cast<std::uint8_t>(rng())});
    }
  }
  Eigen::Quaterniond turn(metres(rng), metres(rng), metres(rng), metres(rng));
  scan.ecef_from_sensor =
      *Pose::from_quaternion(turn.normalized(), {4177000.0 + metres(rng), 855000, 4728000});
  scan.utime = static_cast<std::int64_t>(rng() % 2'000'000'000'000'000);
  return scan;
}

/// A folder of `scans` scans of 10 points, and what was written.
std::vector<SensorScan> fill(const TemporaryFolder& folder, std::size_t scans, bool coloured) {
  auto rng = test::engine();
  auto writer = KittiWriter::create(folder.path());
  REQUIRE(writer.has_value());
  std::vector<SensorScan> written;
  for (std::size_t i = 0; i < scans; ++i) {
    written.push_back(any_scan(rng, 10, coloured));
    REQUIRE(writer->write(written.back()).has_value());
  }
  return written;
}

Result<KittiFolder> open(const TemporaryFolder& folder, const std::string& poses = "poses.txt") {
  return KittiFolder::open(folder.path(), {poses, std::nullopt});
}

TEST_CASE("what the writer writes the folder reads, bit for bit", "[io][oracle]") {
  const bool coloured = GENERATE(false, true);
  const TemporaryFolder folder;
  const auto written = fill(folder, 5, coloured);
  const auto opened = open(folder);
  REQUIRE(opened.has_value());
  REQUIRE(opened->scan_count() == 5);
  REQUIRE_FALSE(opened->ending().has_value());
  for (std::size_t i = 0; i < 5; ++i) {
    const auto read = opened->read(i);
    REQUIRE(read.has_value());
    REQUIRE_FALSE(read->damage.has_value());
    REQUIRE(read->scan.points_sensor == written[i].points_sensor);
    REQUIRE(read->scan.intensities == written[i].intensities);
    REQUIRE(read->scan.colours == written[i].colours);
    REQUIRE(read->scan.ecef_from_sensor == written[i].ecef_from_sensor);
    REQUIRE(read->scan.utime == written[i].utime);
  }
  REQUIRE(opened->read(5).error().code == ErrorCode::kOutOfRange);
}

TEST_CASE("points lie in a .bin as four little-endian floats", "[io]") {
  const TemporaryFolder folder;
  fill(folder, 1, false);
  const unsigned char bytes[] = {0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0x40, 0x3f, 0, 0, 0, 0x3f};
  folder.write("velodyne/000000.bin", {reinterpret_cast<const char*>(bytes), sizeof bytes});
  const auto read = open(folder)->read(0);
  REQUIRE(read.has_value());
  REQUIRE(read->scan.points_sensor.size() == 1);
  REQUIRE(read->scan.points_sensor[0] == Eigen::Vector3f(1, -2, 0.75));
  REQUIRE(read->scan.intensities[0] == 0.5f);
}

TEST_CASE("a .bin cut anywhere gives its whole points and says so", "[io]") {
  const TemporaryFolder folder;
  const auto written = fill(folder, 1, true);
  const std::string whole = folder.read("velodyne/000000.bin");
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    folder.write("velodyne/000000.bin", whole.substr(0, size));
    const auto read = open(folder)->read(0);
    CAPTURE(size);
    REQUIRE(read.has_value());
    REQUIRE(read->scan.points_sensor.size() == size / 16);
    REQUIRE(std::equal(read->scan.points_sensor.begin(), read->scan.points_sensor.end(),
                       written[0].points_sensor.begin()));
    REQUIRE(read->damage.has_value() == (size != whole.size()));
    if (size % 16 != 0) {
      REQUIRE(read->scan.colours.size() == size / 16);
      REQUIRE_THAT(read->damage->message,
                   Contains("000000.bin") && Contains(std::to_string(size) + " bytes"));
    }
  }
}

TEST_CASE("colours that are not one a point are left out, with the reason", "[io]") {
  const TemporaryFolder folder;
  fill(folder, 1, true);
  folder.write("colours/000000.bin", std::string(29, 'c'));
  const auto read = open(folder)->read(0);
  REQUIRE(read.has_value());
  REQUIRE(read->scan.points_sensor.size() == 10);
  REQUIRE(read->scan.colours.empty());
  REQUIRE_THAT(read->damage->message, Contains("colours") && Contains("29 bytes"));
}

TEST_CASE("points that are not numbers are kept", "[io]") {
  const TemporaryFolder folder;
  auto rng = test::engine();
  SensorScan scan = any_scan(rng, 4, false);
  scan.points_sensor[2].y() = std::numeric_limits<float>::quiet_NaN();
  REQUIRE(KittiWriter::create(folder.path())->write(scan).has_value());
  const auto read = open(folder)->read(0);
  REQUIRE(read.has_value());
  REQUIRE(read->scan.points_sensor.size() == 4);
  REQUIRE(std::isnan(read->scan.points_sensor[2].y()));
}

TEST_CASE("files that end too early end the folder there and say which", "[io]") {
  const TemporaryFolder folder;
  fill(folder, 4, false);
  const std::string poses = folder.read("poses.txt"), times = folder.read("times.txt");
  SECTION("half a pose") {
    folder.write("poses.txt", poses.substr(0, poses.rfind(' ')));
    REQUIRE(open(folder)->scan_count() == 3);
    REQUIRE_THAT(open(folder)->ending()->message, Contains("poses.txt: line 4: 11 of 12 numbers"));
  }
  SECTION("a time less") {
    folder.write("times.txt", times.substr(0, times.rfind('\n', times.size() - 2) + 1));
    REQUIRE(open(folder)->scan_count() == 3);
    REQUIRE_THAT(open(folder)->ending()->message, Contains("times.txt: 3 lines for 4 scans"));
  }
  SECTION("a scan less") {
    std::filesystem::remove(folder.path() / "velodyne/000003.bin");
    REQUIRE(open(folder)->scan_count() == 3);
    REQUIRE_THAT(open(folder)->ending()->message, Contains("4 lines for 3 scans"));
  }
  SECTION("a scan in the middle missing") {
    std::filesystem::remove(folder.path() / "velodyne/000001.bin");
    REQUIRE(open(folder)->scan_count() == 1);
    REQUIRE_THAT(open(folder)->ending()->message, Contains("velodyne/000001.bin: missing"));
  }
  SECTION("no pose at all") {
    folder.write("poses.txt", "");
    REQUIRE_THAT(open(folder).error().message, Contains("poses.txt: 0 lines for 4 scans"));
  }
}

TEST_CASE("a folder that is none says what is missing", "[io]") {
  const TemporaryFolder folder;
  REQUIRE(open(folder).error().code == ErrorCode::kNotFound);
  REQUIRE_THAT(open(folder).error().message, Contains("velodyne"));
  std::filesystem::create_directories(folder.path() / "velodyne");
  REQUIRE_THAT(open(folder).error().message, Contains("times.txt: no such file"));
  folder.write("times.txt", "1\n");
  REQUIRE_THAT(open(folder, "other.txt").error().message, Contains("other.txt: no such file"));
  folder.write("poses.txt", "1 0 0 4177000 0 1 0 855000 0 0 1 4728000\n");
  REQUIRE_THAT(open(folder).error().message, Contains("000000.bin: missing"));
  std::filesystem::create_directories(folder.path() / "dir.txt");
  REQUIRE_THAT(open(folder, "dir.txt").error().message, Contains("not a regular file"));
}

TEST_CASE("a pose file is looked up in the folder first, then as a path", "[io]") {
  const TemporaryFolder folder, elsewhere;
  fill(folder, 2, false);
  elsewhere.write("mine.txt", folder.read("poses.txt"));
  const std::string outside = (elsewhere.path() / "mine.txt").string();
  REQUIRE(open(folder, outside).has_value());
  std::filesystem::rename(folder.path() / "poses.txt", folder.path() / "mine.txt");
  REQUIRE(open(folder, "mine.txt").has_value());
  REQUIRE_FALSE(open(folder).has_value());
}

TEST_CASE("a scan larger than any sensor's is refused before it is read", "[io]") {
  const TemporaryFolder folder;
  fill(folder, 1, false);
  std::filesystem::resize_file(folder.path() / "velodyne/000000.bin",
                               16 * KittiFolder::kMaxPoints + 1);  // Sparse: takes no disk.
  const auto read = open(folder)->read(0);
  REQUIRE_FALSE(read.has_value());
  REQUIRE(read.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(read.error().message, Contains("000000.bin: 268435457 bytes"));
}

TEST_CASE("the writer refuses a folder with scans and a scan that contradicts itself", "[io]") {
  const TemporaryFolder folder;
  fill(folder, 1, false);
  const auto again = KittiWriter::create(folder.path());
  REQUIRE_FALSE(again.has_value());
  REQUIRE(again.error().code == ErrorCode::kInvalid);

  const TemporaryFolder fresh;
  auto rng = test::engine();
  SensorScan scan = any_scan(rng, 3, true);
  scan.colours.pop_back();
  REQUIRE(KittiWriter::create(fresh.path())->write(scan).error().code == ErrorCode::kInvalid);
}

TEST_CASE("a disk that is full is an error with its name", "[io]") {
  if (!std::filesystem::exists("/dev/full")) return;
  const TemporaryFolder folder;
  auto rng = test::engine();
  auto writer = KittiWriter::create(folder.path());
  REQUIRE(writer.has_value());
  std::filesystem::create_symlink("/dev/full", folder.path() / "velodyne/000000.bin");
  const auto status = writer->write(any_scan(rng, 1000, false));
  REQUIRE_FALSE(status.has_value());
  REQUIRE(status.error().code == ErrorCode::kNoSpace);
  REQUIRE_THAT(status.error().message, Contains("velodyne/000000.bin"));
  REQUIRE(writer->written() == 0);
  REQUIRE(folder.read("times.txt").empty());
}

TEST_CASE("a sensor scan becomes rays from its origin in ECEF", "[io]") {
  auto rng = test::engine();
  const SensorScan seen = any_scan(rng, 50, true);
  const Scan scan = to_scan(seen, 0.03, 1.5);
  REQUIRE(scan.origin_ecef == seen.ecef_from_sensor.translation());
  REQUIRE(scan.endpoints_ecef.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    const Eigen::Vector3d expected =
        seen.ecef_from_sensor.isometry() * seen.points_sensor[i].cast<double>();
    REQUIRE((scan.endpoints_ecef[i] - expected).norm() < 1e-8);
  }
  REQUIRE(scan.colours == seen.colours);
  REQUIRE((scan.sigma == 0.03 && scan.min_range == 1.5 && scan.utime == seen.utime));
}

}  // namespace
}  // namespace voxatlas
