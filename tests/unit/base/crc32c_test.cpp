#include "base/crc32c.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Oracle: the polynomial division, bit by bit (reflected 0x1EDC6F41).
std::uint32_t crc32c_by_bits(ByteView bytes) {
  std::uint32_t state = ~0u;
  for (const auto byte : bytes) {
    state ^= byte;
    for (int bit = 0; bit < 8; ++bit) state = state >> 1 ^ ((state & 1) != 0 ? 0x82F63B78u : 0u);
  }
  return ~state;
}

TEST_CASE("crc32c gives the published check value", "[base]") {
  REQUIRE(crc32c(as_bytes("123456789")) == 0xE3069283u);
  REQUIRE(crc32c({}) == 0);
}

TEST_CASE("crc32c agrees with the division bit by bit, whole and in pieces", "[base][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (std::size_t size = 0; size < 300; ++size) {
    Bytes bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    const auto expected = crc32c_by_bits(bytes);
    REQUIRE(crc32c(bytes) == expected);
    const std::size_t cut = size == 0 ? 0 : rng() % size;
    REQUIRE(crc32c(ByteView(bytes).subspan(cut), crc32c(ByteView(bytes).first(cut))) == expected);
  }
}

}  // namespace
}  // namespace voxatlas
