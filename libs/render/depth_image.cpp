#include "render/depth_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace voxatlas {
namespace {

std::uint16_t steps_of(float z, double metres_a_step) {
  if (z == CellImage::kNowhere) return 0;
  const double steps = static_cast<double>(z) / metres_a_step;
  return static_cast<std::uint16_t>(std::clamp(std::round(steps), 1.0, 65535.0));
}

}  // namespace

Bytes depth_metres(const CellImage& cells) {
  Bytes bytes(cells.z.size() * sizeof(float));
  if (!bytes.empty()) std::memcpy(bytes.data(), cells.z.data(), bytes.size());
  return bytes;
}

Result<Bytes> depth_steps(const CellImage& cells, double metres_a_step) {
  if (!(metres_a_step > 0 && std::isfinite(metres_a_step))) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a depth image in steps of {} m", metres_a_step));
  }
  Bytes bytes;
  bytes.reserve(cells.z.size() * sizeof(std::uint16_t));
  ByteWriter writer(bytes);
  for (const float z : cells.z) writer.put(steps_of(z, metres_a_step));
  return bytes;
}

}  // namespace voxatlas
