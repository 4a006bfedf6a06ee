#include "cli/camera_track.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "geodesy/enu_frame.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

const Lens kLens = Lens::of_view(60, 320, 200);

Eigen::Vector3d ecef(double latitude, double longitude, double height) {
  return to_ecef({latitude, longitude, height}).value();
}

Result<std::vector<Camera>> track_of(const std::string& text, double rate) {
  const test::TempDir folder;
  const std::string file = folder / "path.txt";
  std::ofstream(file) << text;
  return read_track(file, rate, kLens);
}

TEST_CASE("an orbit goes once round, level, always looking at its middle", "[cli]") {
  const auto frame = EnuFrame::at(Geodetic{48.1, 11.5, 500}).value();
  const Eigen::Vector3d target = frame.origin_ecef();
  const auto first =
      Camera::look_at(frame.to_ecef({-30, 10, 20}), target, frame.up_ecef(), kLens).value();
  const auto track = orbit(first, target, 12).value();
  REQUIRE(track.size() == 12);
  REQUIRE((track[0].position() - first.position()).norm() < 1e-6);
  for (std::size_t i = 0; i < 12; ++i) {
    const Eigen::Vector3d eye = frame.to_enu(track[i].position());
    REQUIRE(eye.z() == Approx(20).margin(1e-3));
    REQUIRE(eye.norm() == Approx(std::sqrt(1400.0)));
    REQUIRE(track[i].to_pixel(track[i].to_camera(target)).x() == Approx(160));
    const Eigen::Vector3d next = frame.to_enu(track[(i + 1) % 12].position());
    REQUIRE((next - eye).norm() ==
            Approx((frame.to_enu(track[1].position()) - frame.to_enu(track[0].position())).norm()));
  }
}

TEST_CASE("a path's file gives a camera each 1/rate seconds", "[cli]") {
  const auto track = track_of(
      "# seconds eye target\n"
      "10 48.1,11.5,510 48.1,11.501,500\n"
      "\n"
      "11 48.1,11.5,530 48.1,11.501,500  # up\n"
      "13 48.1,11.5,530 48.101,11.5,500\n",
      10);
  REQUIRE(track.has_value());
  REQUIRE(track->size() == 31);
  const auto away = [&](std::size_t i, const Eigen::Vector3d& p) {
    return ((*track)[i].position() - p).norm();
  };
  REQUIRE(away(0, ecef(48.1, 11.5, 510)) < 1e-6);
  REQUIRE(away(5, ecef(48.1, 11.5, 520)) < 1e-3);
  REQUIRE(away(10, ecef(48.1, 11.5, 530)) < 1e-6);
  REQUIRE(away(30, ecef(48.1, 11.5, 530)) < 1e-6);
  const Camera& last = track->back();
  REQUIRE(last.to_pixel(last.to_camera(ecef(48.101, 11.5, 500))).x() == Approx(160));
}

TEST_CASE("a path's file that is none is refused with its line", "[cli]") {
  const auto refused = [](const std::string& text, const std::string& word) {
    const auto track = track_of(text, 10);
    REQUIRE_FALSE(track.has_value());
    REQUIRE_THAT(track.error().message, Catch::Contains(word));
  };
  refused("", "no line");
  refused("0 48,11,500\n", "path.txt:1");
  refused("0 48,11,500 48,11,x\n", "48,11,x");
  refused("0 48,11,500 48,12,500\n0 48,11,500 48,12,500\n", "path.txt:2");
  refused("nan 48,11,500 48,12,500\n", "path.txt:1");
  refused("0 48,11,500 48,11,500\n", "same point");
  refused("0 48,11,500 48,12,500\n1000 48,11,501 48,12,500\n", "900");
  refused("0 48,11,500 48,12,500 more\n", "more");
  REQUIRE(read_track("/nowhere/path.txt", 10, kLens).error().code == ErrorCode::kIo);
}

TEST_CASE("a track's rows are what a request carries", "[cli]") {
  const auto track = track_of("0 48,11,500 48,12,500\n1 48,11,501 48,12,500\n", 4).value();
  const Bytes rows = path_rows(track, 60).value();
  REQUIRE(rows.size() == 5 * 64);
  ByteReader reader(rows);
  for (std::size_t i = 0; i < 5; ++i) {
    REQUIRE(reader.get<double>() == Approx(static_cast<double>(i) / 60));
    for (int axis = 0; axis < 3; ++axis) {
      REQUIRE(reader.get<double>() == track[i].position()[axis]);
    }
    REQUIRE(reader.get<double>() == track[i].orientation().w());
    for (int j = 0; j < 3; ++j) (void)reader.get<double>();
  }
  REQUIRE_FALSE(path_rows(std::vector<Camera>(901, track[0]), 60).has_value());
}

}  // namespace
}  // namespace voxatlas
