#include "cli/scan_input.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "base/bytes.hpp"
#include "base/sha256.hpp"
#include "cli/place_text.hpp"
#include "io/kitti.hpp"
#include "sim/drive.hpp"

namespace voxatlas {

std::int64_t identity_of_input(const std::string& text) {
  const Sha256Digest digest = sha256(as_bytes(text));
  return ByteReader(digest).get<std::int64_t>() & INT64_MAX;
}

Result<ScanInput> open_kitti(const KittiInput& input) {
  KittiOptions options;
  options.poses = input.poses;
  if (!input.origin.empty()) {
    auto origin = parse_place("--origin", input.origin);
    if (!origin) return pass_on(origin);
    options.origin = *origin;
  }
  auto opened = KittiFolder::open(input.folder, options);
  if (!opened) return pass_on(opened);
  auto folder = std::make_shared<KittiFolder>(std::move(*opened));  // Owned by both closures below.

  ScanInput result;
  std::error_code none;
  const auto path = std::filesystem::weakly_canonical(input.folder, none);
  result.name = path.filename().empty() ? path.parent_path().filename() : path.filename();
  result.identity = identity_of_input(path.string() + '\n' + input.poses + '\n' + input.origin);
  result.scans = folder->scan_count();
  result.min_range = 2.5;  // Nearer returns of a scanner on a car's roof are the car.
  result.ending = folder->ending();
  result.read = [folder](std::size_t index) -> Result<InputScan> {
    auto scan = folder->read(index);
    if (!scan) return pass_on(scan);
    return InputScan{std::move(scan->scan), std::move(scan->damage), {}, {}};
  };
  return result;
}

/// The default drive keeps its identity, whatever else can be chosen.
static std::string describe(const SimulatedInput& input) {
  auto text = fmt::format("simulated drive, seed {}", input.seed);
  if (!input.place.empty()) text += ", at " + input.place;
  if (input.speed != SimulatedInput{}.speed) text += fmt::format(", speed {}", input.speed);
  if (input.azimuth_step_deg != SimulatedInput{}.azimuth_step_deg) {
    text += fmt::format(", azimuth step {}", input.azimuth_step_deg);
  }
  return text;
}

Result<ScanInput> open_simulated(const SimulatedInput& input) {
  CityOptions city_options;
  city_options.seed = input.seed;
  if (!input.place.empty()) {
    auto place = parse_place("--place", input.place);
    if (!place) return pass_on(place);
    city_options.place = *place;
  }
  auto made = City::create(city_options);
  if (!made) return pass_on(made);
  auto city = std::make_shared<City>(std::move(*made));  // Owned by the closure, with its drive.
  DriveOptions drive_options;
  drive_options.scans = input.scans;
  drive_options.seed = input.seed;
  drive_options.speed = input.speed;
  drive_options.azimuth_step_deg = input.azimuth_step_deg;
  auto drive = Drive::create(*city, drive_options);
  if (!drive) return pass_on(drive);

  ScanInput result;
  result.name = "simulated";
  result.identity = identity_of_input(describe(input));
  result.scans = input.scans;
  result.sigma = drive_options.sigma;
  result.read = [city, drive = std::move(*drive)](std::size_t index) -> Result<InputScan> {
    return InputScan{drive.simulate(index), {}, {}, {}};
  };
  return result;
}

}  // namespace voxatlas
