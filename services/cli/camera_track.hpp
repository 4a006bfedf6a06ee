#pragma once

#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "render/camera.hpp"

namespace voxatlas {

/// Cameras in a row, a picture each.

/// As render_request_t's path, one a place at this rate. Errors: kInvalid for more than a request
/// takes.
Result<Bytes> path_rows(const std::vector<Camera>& track, double rate);
inline constexpr std::size_t kLongestTrack = 900;

/// Once round `target`, from where `first` stands, at its height; `count` pictures.
/// Errors: the Camera's.
Result<std::vector<Camera>> orbit(const Camera& first, const Eigen::Vector3d& target_ecef,
                                  int count);

/// A file's camera path: lines "SECONDS LAT,LON,HEIGHT LAT,LON,HEIGHT", eye and what it looks at,
/// ascending; '#' begins a comment. Between lines both go straight; `rate` pictures a second.
/// Errors: kInvalid, naming file and line; kIo; the Camera's.
Result<std::vector<Camera>> read_track(const std::string& file, double rate, const Lens& lens);

}  // namespace voxatlas
