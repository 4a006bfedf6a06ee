// Any text is refused, or gives entries that keep what the parsers promise.
#include "base/bytes.hpp"
#include "base/check.hpp"
#include "geodesy/ecef.hpp"
#include "io/kitti_text.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto text = voxatlas::as_text({data, size});
  if (const auto times = voxatlas::parse_kitti_times(text, "times.txt")) {
    for (const auto utime : times->entries)
      VOX_CHECK(utime >= 0 && utime <= 100'000'000'000'000'000);
  }
  if (const auto poses = voxatlas::parse_kitti_poses(text, "poses.txt")) {
    for (const auto& pose : poses->entries) {
      VOX_CHECK(pose.translation().cwiseAbs().maxCoeff() < voxatlas::kCubeHalf);
    }
  }
  return 0;
}
