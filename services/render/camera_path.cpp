#include "render/camera_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kRowBytes = 64;
constexpr double kHardlyAnything = 1e-9;  // Seconds: what rounding may take from a whole number.

}  // namespace

Result<CameraPath> CameraPath::create(ByteView bytes, const Lens& lens) {
  if (bytes.size() % kRowBytes != 0) {
    return fail(ErrorCode::kInvalid,
                fmt::format("path: {} bytes are no whole rows of {}", bytes.size(), kRowBytes));
  }
  std::vector<Row> rows;
  ByteReader reader(bytes);
  for (std::size_t i = 0; i < bytes.size() / kRowBytes; ++i) {
    const double seconds = reader.get<double>();
    double p[3], q[4];
    for (double& x : p) x = reader.get<double>();
    for (double& x : q) x = reader.get<double>();
    const bool ascends = rows.empty() ? seconds == 0 : seconds > rows.back().seconds;
    if (!ascends || !(seconds <= kMaxSeconds)) {
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("path: row {} is at {} s; they start at 0, ascend, and end by {}", i,
                              seconds, kMaxSeconds));
    }
    auto camera = Camera::create({p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, lens);
    if (!camera) return pass_on(camera, fmt::format("path: row {}", i));
    rows.push_back({seconds, camera->position(), camera->orientation()});
  }
  if (rows.empty()) return fail(ErrorCode::kOutOfRange, "path: it has no row");
  return CameraPath(std::move(rows), lens);
}

std::int32_t CameraPath::places(double rate) const {
  return static_cast<std::int32_t>(std::floor(seconds() * rate + kHardlyAnything)) + 1;
}

Camera CameraPath::at(double seconds) const {
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), seconds,
                                      [](double at, const Row& row) { return at < row.seconds; });
  const Row& from = after == rows_.begin() ? rows_.front() : *(after - 1);
  const Row& to = after == rows_.end() ? rows_.back() : *after;
  const double span = to.seconds - from.seconds;
  const double part = span > 0 ? std::clamp((seconds - from.seconds) / span, 0.0, 1.0) : 0;
  auto camera = Camera::create(from.position_ecef + part * (to.position_ecef - from.position_ecef),
                               from.ecef_from_camera.slerp(part, to.ecef_from_camera), lens_);
  VOX_CHECK(camera.has_value());  // Between two that are.
  return *camera;
}

}  // namespace voxatlas
