#include "grid/tile_key.hpp"

#include <catch2/catch.hpp>
#include <unordered_set>

#include "support/engine.hpp"
#include "unit/grid/morton_bits.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a TileKey is the Morton code of its index, both ways", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 100'000; ++i) {
    Index3 index{};
    for (auto& n : index) n = static_cast<std::uint32_t>(rng() >> 43);
    const auto key = TileKey::from_index(index);
    REQUIRE(key.has_value());
    REQUIRE(key->morton() == test::morton_by_bits(index));
    REQUIRE(key->index() == index);
    REQUIRE(TileKey::from_morton(key->morton()) == *key);
  }
}

TEST_CASE("a TileKey refuses an axis of 22 bits and a code of 64, and names them", "[grid]") {
  const std::size_t axis = GENERATE(0u, 1u, 2u);
  const std::uint32_t bad = GENERATE(1u << 21, ~0u);
  Index3 index{1, 2, 3};
  index[axis] = (1u << 21) - 1;
  REQUIRE(TileKey::from_index(index).has_value());
  index[axis] = bad;
  const auto off = TileKey::from_index(index);
  REQUIRE_FALSE(off.has_value());
  REQUIRE(off.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(off.error().message, Catch::Contains(std::to_string(bad)));
  REQUIRE(TileKey::from_morton((std::uint64_t{1} << 63) - 1).has_value());
  const auto refused = TileKey::from_morton(std::uint64_t{1} << 63);
  REQUIRE_FALSE(refused.has_value());
  REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(refused.error().message, Catch::Contains("0x8000000000000000"));
}

TEST_CASE("TileKeys order by Morton code and hash apart", "[grid]") {
  std::unordered_set<std::size_t> low_bits;
  for (std::uint64_t code = 0; code < 4096; ++code) {
    const auto key = TileKey::from_morton(code);
    const auto next = TileKey::from_morton(code + 1);
    REQUIRE(*key < *next);
    low_bits.insert(std::hash<TileKey>{}(*key) & 0xffff);
  }
  // 4096 of 65 536 places at random: 3971 differ on average. Equal would be 4096, clustered few.
  REQUIRE(low_bits.size() > 3800);
}

}  // namespace
}  // namespace voxatlas
