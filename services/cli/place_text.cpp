#include "cli/place_text.hpp"

#include <fmt/format.h>

#include <charconv>

namespace voxatlas {

Result<Geodetic> parse_place(const std::string& option, const std::string& text) {
  double numbers[3] = {};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int i = 0; i < 3; ++i) {
    const auto parsed = std::from_chars(at, end, numbers[i]);
    const bool ends_well = i == 2 ? parsed.ptr == end : parsed.ptr != end && *parsed.ptr == ',';
    if (parsed.ec != std::errc{} || !ends_well) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{} {}: give LAT,LON,HEIGHT in degrees and metres, such as "
                              "49.0112,8.4229,112.8",
                              option, text));
    }
    at = parsed.ptr + 1;
  }
  return Geodetic{numbers[0], numbers[1], numbers[2]};
}

}  // namespace voxatlas
