#include "cli/place_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace voxatlas {

namespace {

/// Exactly so many numbers with commas between them.
template <std::size_t Count>
std::optional<std::array<double, Count>> parse_numbers(const std::string& text) {
  std::array<double, Count> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < Count; ++i) {
    const auto parsed = std::from_chars(at, end, numbers[i]);
    const bool ends_well =
        i + 1 == Count ? parsed.ptr == end : parsed.ptr != end && *parsed.ptr == ',';
    if (parsed.ec != std::errc{} || !ends_well) return std::nullopt;
    at = parsed.ptr + 1;
  }
  return numbers;
}

}  // namespace

Result<Geodetic> parse_place(const std::string& option, const std::string& text) {
  const auto numbers = parse_numbers<3>(text);
  if (!numbers) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{} {}: give LAT,LON,HEIGHT in degrees and metres, such as "
                            "49.0112,8.4229,112.8",
                            option, text));
  }
  return Geodetic{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

Result<Box> parse_box(const std::string& option, const std::string& text) {
  const auto numbers = parse_numbers<6>(text);
  if (!numbers || !std::ranges::all_of(*numbers, [](double n) { return std::isfinite(n); })) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{} {}: give X,Y,Z,X,Y,Z, two opposite corners in ECEF, metres", option, text));
  }
  const Eigen::Vector3d a(numbers->data()), b(numbers->data() + 3);
  return Box{a.cwiseMin(b), a.cwiseMax(b)};
}

}  // namespace voxatlas
