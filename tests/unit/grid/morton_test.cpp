#include "grid/morton.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"
#include "unit/grid/morton_bits.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a Morton code agrees with one written bit by bit, and comes back", "[grid][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 100'000; ++i) {
    Index3 index{};
    for (auto& n : index) n = static_cast<std::uint32_t>(rng() >> (43 + rng() % 21));
    CAPTURE(index);
    const auto code = morton_encode(index);
    REQUIRE(code == test::morton_by_bits(index));
    REQUIRE(morton_decode(code) == index);
  }
}

TEST_CASE("each single bit of each axis has its place in a Morton code", "[grid]") {
  for (unsigned bit = 0; bit < 21; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      Index3 index{};
      index[axis] = 1u << bit;
      REQUIRE(morton_encode(index) == std::uint64_t{1} << (3 * bit + axis));
      REQUIRE(morton_decode(std::uint64_t{1} << (3 * bit + axis)) == index);
    }
  }
}

TEST_CASE("Morton codes below 8^7 and cells of a tile are the same set", "[grid]") {
  for (std::uint64_t code = 0; code < 1u << 21; ++code) {
    const auto index = morton_decode(code);
    const bool in_tile = index[0] < 128 && index[1] < 128 && index[2] < 128;
    if (!in_tile || morton_encode(index) != code) FAIL("code " << code);
  }
}

}  // namespace
}  // namespace voxatlas
