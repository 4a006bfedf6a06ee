#include <catch2/catch.hpp>

#include "io/kitti.hpp"
#include "io/kitti_writer.hpp"
#include "sim/drive.hpp"
#include "temporary_folder.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a simulated drive gives the same rays from a folder as from memory", "[io][sim]") {
  const auto city = City::create({});
  REQUIRE(city.has_value());
  DriveOptions options;
  options.scans = 6;
  options.azimuth_step_deg = 4;
  const auto drive = Drive::create(*city, options);
  REQUIRE(drive.has_value());
  const test::TemporaryFolder folder;
  auto writer = KittiWriter::create(folder.path());
  REQUIRE(writer.has_value());
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    REQUIRE(writer->write(drive->simulate(i)).has_value());
  }

  const auto opened = KittiFolder::open(folder.path(), {});
  REQUIRE(opened.has_value());
  REQUIRE(opened->scan_count() == drive->scan_count());
  REQUIRE_FALSE(opened->ending().has_value());
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    const auto read = opened->read(i);
    REQUIRE(read.has_value());
    const Scan from_file = to_scan(read->scan, 0.02, 1),
               from_memory = to_scan(drive->simulate(i), 0.02, 1);
    REQUIRE(from_file.origin_ecef == from_memory.origin_ecef);
    REQUIRE(from_file.endpoints_ecef == from_memory.endpoints_ecef);
    REQUIRE(from_file.colours == from_memory.colours);
    REQUIRE(from_file.utime == from_memory.utime);
  }
}

}  // namespace
}  // namespace voxatlas
