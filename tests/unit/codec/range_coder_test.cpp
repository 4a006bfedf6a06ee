#include "codec/range_coder.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// `bits`, each with one of a few chances.
Bytes encoded(const std::vector<bool>& bits, std::size_t contexts) {
  Bytes bytes;
  RangeEncoder coder(bytes);
  std::vector<Chance> chances(contexts);
  for (std::size_t i = 0; i < bits.size(); ++i) coder.code(chances[i % contexts], bits[i]);
  coder.finish();
  return bytes;
}

TEST_CASE("bits come back as they went, whatever their odds", "[codec][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (const unsigned odds : {2u, 3u, 50u, 3000u, 1'000'000u}) {
    for (int round = 0; round < 100; ++round) {
      std::vector<bool> bits(rng() % 3000);
      const bool rare = rng() % 2 == 0;
      for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = (rng() % odds == 0) == rare;
      const std::size_t contexts = 1 + rng() % 5;
      const auto bytes = encoded(bits, contexts);
      RangeDecoder decoder(bytes);
      std::vector<Chance> chances(contexts);
      for (std::size_t i = 0; i < bits.size(); ++i) {
        REQUIRE(decoder.code(chances[i % contexts], false) == bits[i]);
      }
      REQUIRE(decoder.at_end());
    }
  }
}

TEST_CASE("bits cost what their entropy says", "[codec]") {
  auto rng = test::engine();
  std::vector<bool> bits(200'000);
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = rng() % 10 == 0;
  const double entropy = -(0.1 * std::log2(0.1) + 0.9 * std::log2(0.9)) * 200'000 / 8;
  REQUIRE(static_cast<double>(encoded(bits, 1).size()) == Approx(entropy).epsilon(0.03));
  REQUIRE(encoded(std::vector<bool>(200'000), 1).size() < 30);
  REQUIRE(encoded({}, 1).empty());
}

TEST_CASE("bytes that go on behind the last bit are noticed", "[codec]") {
  const std::vector<bool> bits(1000);
  auto bytes = encoded(bits, 1);
  bytes.insert(bytes.end(), 5, 0);
  RangeDecoder decoder(bytes);
  Chance chance;
  for (std::size_t i = 0; i < bits.size(); ++i) decoder.code(chance, false);
  REQUIRE_FALSE(decoder.at_end());
}

}  // namespace
}  // namespace voxatlas
