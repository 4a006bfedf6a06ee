#pragma once

#include <string>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "grid/grid.hpp"

namespace voxatlas {

/// "LAT,LON,HEIGHT" in degrees and metres, such as "49.0112,8.4229,112.8".
/// Errors: kInvalid, naming `option` and the text.
Result<Geodetic> parse_place(const std::string& option, const std::string& text);

/// "X,Y,Z,X,Y,Z": two opposite corners in ECEF, metres, in any order.
/// Errors: kInvalid, naming `option` and the text.
Result<Box> parse_box(const std::string& option, const std::string& text);

}  // namespace voxatlas
