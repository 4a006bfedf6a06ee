#include "octree/tile_delta.hpp"

#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

Bytes encoded(const TileDelta& delta) {
  Bytes bytes;
  encode_delta(delta, bytes);
  return bytes;
}

/// Either refused as corrupt, or the one encoding of a valid delta.
void require_canonical(const Bytes& bytes) {
  const auto delta = decode_delta(bytes);
  if (delta.has_value()) {
    REQUIRE(delta->valid());
    REQUIRE(encoded(*delta) == bytes);
  } else {
    REQUIRE(delta.error().code == ErrorCode::kCorrupt);
  }
}

/// FORMAT.md's example.
TileDelta example() {
  TileDelta delta;
  delta.misses.depth = 4;
  delta.misses.insert({4, 9});
  delta.hits.insert(CellKey::of_voxel({1, 0, 0}, kDepth));
  delta.coloured = delta.hits;
  delta.colours = {{255, 128, 0}};
  return delta;
}

/// One delta for each pair of depths; only raw engine output, so the same everywhere.
TileDelta golden(int number) {
  test::RandomOctree random(1000 + static_cast<std::uint64_t>(number));
  for (;;) {
    TileDelta delta = random.delta();
    if (delta.hits.depth == number && (number == 0 || !delta.misses.empty())) return delta;
  }
}

std::string golden_path(int number) {
  return std::string(VOX_TEST_DATA) + "/octree/delta_" + std::to_string(number) + ".bin";
}

TEST_CASE("a delta survives its bytes", "[octree]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int round = 0; round < 400; ++round) {
    const TileDelta delta = random.delta();
    REQUIRE(delta.valid());
    const auto again = decode_delta(encoded(delta));
    REQUIRE(again.has_value());
    REQUIRE(*again == delta);
  }
}

TEST_CASE("a delta has the same bytes with every set of instructions, and each reads them",
          "[octree][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int round = 0; round < 100; ++round) {
    const TileDelta delta = random.delta();
    const auto bytes = encoded(delta);
    for (const auto target : hwy::SupportedAndGeneratedTargets()) {
      CAPTURE(hwy::TargetName(target), round);
      hwy::SetSupportedTargetsForTest(target);
      const auto same = encoded(delta);
      const auto again = decode_delta(bytes);
      hwy::SetSupportedTargetsForTest(0);
      REQUIRE(same == bytes);
      REQUIRE(again.has_value());
      REQUIRE(*again == delta);
    }
  }
}

TEST_CASE("encode_delta appends, and an empty delta is six bytes", "[octree]") {
  Bytes bytes{42};
  encode_delta({}, bytes);
  REQUIRE(bytes == Bytes{42, 1, 7, 0, 7, 0, 0});
  REQUIRE(decode_delta(ByteView(bytes).subspan(1)) == TileDelta{});
}

TEST_CASE("the example of FORMAT.md is what is written", "[octree]") {
  REQUIRE(encoded(example()) == Bytes{1, 4, 1, 1, 2, 2, 7, 1, 1, 1, 1, 1, 1, 2, 1, 0xff, 0x80, 0});
}

TEST_CASE("the golden deltas keep their bytes", "[octree][golden]") {
  for (int number = 0; number <= kDepth; ++number) {
    std::ifstream in(golden_path(number), std::ios::binary);
    const Bytes stored{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    CAPTURE(number);
    REQUIRE(encoded(golden(number)) == stored);
  }
}

// Run by hand when the format gets a new version: unit_octree "write the golden deltas".
TEST_CASE("write the golden deltas", "[.write]") {
  for (int number = 0; number <= kDepth; ++number) {
    const Bytes bytes = encoded(golden(number));
    std::ofstream out(golden_path(number), std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    REQUIRE(out.good());
  }
}

TEST_CASE("a delta cut short or prolonged anywhere is refused", "[octree][hostile]") {
  test::RandomOctree random(test::seed());
  for (int round = 0; round < 20; ++round) {
    const Bytes bytes = encoded(random.delta());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const auto delta = decode_delta(ByteView(bytes).first(size));
      REQUIRE_FALSE(delta.has_value());
      REQUIRE(delta.error().code == ErrorCode::kCorrupt);
    }
    Bytes longer = bytes;
    longer.push_back(0);
    REQUIRE_FALSE(decode_delta(longer).has_value());
  }
}

TEST_CASE("changed bytes are refused or are another delta's only encoding", "[octree][hostile]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int round = 0; round < 50; ++round) {
    const Bytes bytes = encoded(random.delta());
    for (int i = 0; i < 200; ++i) {
      Bytes changed = bytes;
      for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
        changed[random.below(static_cast<std::uint32_t>(changed.size()))] ^=
            static_cast<std::uint8_t>(1u << random.below(8));
      }
      require_canonical(changed);
    }
  }
  for (int i = 0; i < 20'000; ++i) {
    Bytes noise(random.below(40));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.below(random.below(256) + 1));
    if (!noise.empty()) noise[0] = 1;
    require_canonical(noise);
  }
}

TEST_CASE("what encode_delta would not write is refused", "[octree][hostile]") {
  const auto refused = [](const Bytes& bytes, const char* what) {
    const auto delta = decode_delta(bytes);
    CAPTURE(bytes);
    REQUIRE_FALSE(delta.has_value());
    REQUIRE_THAT(delta.error().message, Catch::Contains(what));
  };
  refused({2, 7, 0, 7, 0, 0}, "version");
  refused({1, 8, 0, 7, 0, 0}, "misses");
  refused({1, 0, 2, 7, 0, 0}, "misses");                            // Depth 0 has one cell.
  refused({1, 2, 1, 0, 7, 0, 0}, "misses");                         // A zero byte announced.
  refused({1, 3, 1, 0, 7, 0, 0}, "misses");                         // A zero word.
  refused({1, 4, 1, 0, 7, 0, 0}, "misses");                         // A zero block.
  refused({1, 7, 0, 7, 1, 1, 1, 1, 0, 0}, "hits");                  // An empty brick.
  refused({1, 7, 0, 5, 1, 1, 1, 1, 0, 0}, "hits");                  // The same at depth 5.
  refused({1, 7, 0, 7, 0, 1}, "colours");                           // Every hit of none.
  refused({1, 7, 0, 0, 1, 3}, "colours");                           // No such kind.
  refused({1, 7, 0, 1, 3, 2, 3, 1, 2, 3, 4, 5, 6}, "colours");      // Every hit, spelt as some.
  refused({1, 7, 0, 1, 3, 2, 0}, "colours");                        // None, spelt as some.
  refused({1, 7, 0, 1, 3, 2, 5, 1, 2, 3}, "colours");               // A bit beyond the hits.
  refused({1, 7, 0, 1, 3, 1, 1, 2, 3}, "colours");                  // A colour missing.
  refused({1, 0, 1, 1, 3, 0}, "missed and hit");                    // The tile contains all.
  refused({1, 7, 1, 1, 1, 1, 1, 1, 2, 1, 1, 0}, "missed and hit");  // A voxel in a cell.
  refused({1, 1, 6, 1, 2, 0}, "missed and hit");                    // The same cell.
  REQUIRE(decode_delta(Bytes{1, 7, 0, 1, 3, 2, 1, 1, 2, 3}).has_value());
}

TEST_CASE("a delta that breaks its promises is not valid", "[octree]") {
  REQUIRE(example().valid());
  TileDelta delta = example();
  delta.colours.clear();
  REQUIRE_FALSE(delta.valid());
  delta = example();
  delta.coloured = {};
  delta.coloured.insert({7, 0});
  REQUIRE_FALSE(delta.valid());
  delta = example();
  delta.misses.insert({4, 0});
  REQUIRE_FALSE(delta.valid());
  delta = example();
  delta.misses = {};
  delta.misses.depth = 6;
  delta.misses.insert({6, 0});
  REQUIRE_FALSE(delta.valid());
}

}  // namespace
}  // namespace voxatlas
