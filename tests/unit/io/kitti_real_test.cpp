#include <catch2/catch.hpp>
#include <filesystem>

#include "geodesy/ecef.hpp"
#include "io/kitti.hpp"

namespace voxatlas {
namespace {

TEST_CASE("the real drive through Karlsruhe is read whole, at its place", "[io][real]") {
  const std::filesystem::path folder = std::filesystem::path(VOX_SHARED_DATA) / "kitti_0005";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: " << folder << " is not there");
    return;
  }
  const std::string poses = GENERATE("poses_ecef.txt", "poses_refined_ecef.txt");
  const auto opened = KittiFolder::open(folder, {poses, std::nullopt});
  REQUIRE(opened.has_value());
  REQUIRE(opened->scan_count() == 40);
  REQUIRE_FALSE(opened->ending().has_value());

  const auto place = to_geodetic(opened->ecef_from_sensor(0).translation());
  REQUIRE(place.has_value());
  REQUIRE(place->latitude_deg == Approx(49.01120).margin(1e-5));
  REQUIRE(place->longitude_deg == Approx(8.42288).margin(1e-5));
  REQUIRE(place->height == Approx(113.63).margin(0.01));
  REQUIRE(opened->utime(0) == 1317042272349000);

  std::size_t points = 0;
  for (std::size_t i = 0; i < opened->scan_count(); ++i) {
    const auto read = opened->read(i);
    REQUIRE(read.has_value());
    REQUIRE_FALSE(read->damage.has_value());
    REQUIRE(read->scan.colours.empty());
    points += read->scan.points_sensor.size();
    if (i > 0) REQUIRE(opened->utime(i) > opened->utime(i - 1));
  }
  REQUIRE(points == 4'917'670);  // As the data's own description counts them.
}

}  // namespace
}  // namespace voxatlas
