#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "integrate/sensor_scan.hpp"

namespace voxatlas {

/// A scan, whole or what is whole of it.
struct InputScan {
  SensorScan scan;
  std::optional<Error> damage;  ///< To be told at the end; the scan counts with what it has.
  std::optional<double> sigma, min_range;  ///< Where the scan itself says, metres.
};

/// Where `publish` takes scans from: a folder, or the simulated drive.
struct ScanInput {
  std::string name;  ///< For the source, where none is given.
  std::int64_t identity =
      0;  ///< 63 bits that stay the same for the same input: the default session.
  std::size_t scans = 0;
  double sigma = 0.02;   ///< Where none is given, metres.
  double min_range = 0;  ///< Where none is given, metres.
  std::function<Result<InputScan>(std::size_t)> read;
  std::optional<Error> ending;  ///< Why the input stops early, to be told after all that is whole.
};

struct KittiInput {
  std::string folder;
  std::string poses;
  std::string
      origin;  ///< "LAT,LON,HEIGHT" (degrees, metres), or empty: poses are ecef_from_sensor.
};

/// 63 bits, not negative, that are the same for the same description of an input.
std::int64_t identity_of_input(const std::string& description);

/// Errors: what cannot be read at all; what is damaged at its end gives the whole scans and
/// `ending`.
Result<ScanInput> open_kitti(const KittiInput& input);

/// A drive through the procedural city.
struct SimulatedInput {
  std::size_t scans = 0;
  std::uint64_t seed = 1;         ///< Of the city and the drive.
  std::string place{};            ///< "LAT,LON,HEIGHT" of the city's middle, or empty: Munich.
  double speed = 8;               ///< Metres a second; scans come at 20 Hz.
  double azimuth_step_deg = 0.4;  ///< 54 000 points a scan; 1.1: 20 000, as the paper's drive has.
};

/// Errors: kInvalid and kOutOfRange for a place, a speed or a step that cannot be.
Result<ScanInput> open_simulated(const SimulatedInput& input);

}  // namespace voxatlas
