#include "grid/region_key.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("two tiles share a region when they share a block of 4x4x4 tiles", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 20'000; ++i) {
    Index3 a{};
    Index3 b{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      a[axis] = static_cast<std::uint32_t>(rng() % 1'000'000);
      b[axis] = (a[axis] & ~7u) + static_cast<std::uint32_t>(rng() % 8);  // Near: half share.
    }
    bool same_block = true;
    for (std::size_t axis = 0; axis < 3; ++axis) same_block &= a[axis] / 4 == b[axis] / 4;
    const auto key_a = TileKey::from_index(a);
    const auto key_b = TileKey::from_index(b);
    REQUIRE((RegionKey::of(*key_a) == RegionKey::of(*key_b)) == same_block);
    if (same_block) REQUIRE(shard_of(*key_a, 7) == shard_of(*key_b, 7));
  }
}

TEST_CASE("splitmix64 gives the published sequence of seed 0", "[grid]") {
  const std::uint64_t golden = 0x9e3779b97f4a7c15u;
  REQUIRE(splitmix64(0) == 0xe220a8397b1dcdafu);
  REQUIRE(splitmix64(golden) == 0x6e789e6aa1b965f4u);
  REQUIRE(splitmix64(2 * golden) == 0x06c45d188009454fu);
}

TEST_CASE("shards share neighbouring regions evenly", "[grid]") {
  const std::uint32_t shards = GENERATE(1u, 2u, 3u, 8u);
  std::vector<int> count(shards);
  for (std::uint64_t code = 0; code < 24'000; ++code) {
    const auto shard = shard_of(RegionKey{code}, shards);
    REQUIRE(shard < shards);
    ++count[shard];
  }
  const int fair = 24'000 / static_cast<int>(shards);
  for (const int n : count) REQUIRE(std::abs(n - fair) <= fair / 10);
}

}  // namespace
}  // namespace voxatlas
