#pragma once

#include <string>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"

namespace voxatlas {

/// "LAT,LON,HEIGHT" in degrees and metres, such as "49.0112,8.4229,112.8".
/// Errors: kInvalid, naming `option` and the text.
Result<Geodetic> parse_place(const std::string& option, const std::string& text);

}  // namespace voxatlas
