#include "octree/brick_colours.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("the colours of a brick are a map from voxels to colours", "[octree][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 60; ++round) {
    BrickColours colours;
    std::map<unsigned, Colour> wanted;
    for (int step = 0; step < 25; ++step) {
      VoxelMask voxels{};
      for (auto& word : voxels) word = rng() % 3 == 0 ? ~0ull : rng() & rng() & rng();
      if (rng() % 4 == 0) voxels = kAllVoxels;
      std::array<Rgb, kBrickVoxels> seen{};
      for (auto& rgb : seen) rgb = {static_cast<std::uint8_t>(rng() % 2), 7, 9};
      Colour fixed;
      fixed.add({1, 2, static_cast<std::uint8_t>(rng() % 2)});
      const auto what = rng() % 4;
      if (what == 0) colours.remove(voxels);
      if (what == 1) colours.assign(voxels, fixed);
      if (what > 1) colours.add(voxels, seen);
      for_each_bit(voxels, [&](unsigned voxel) {
        if (what == 0) wanted.erase(voxel);
        if (what == 1) wanted[voxel] = fixed;
        if (what > 1) wanted[voxel].add(seen[voxel]);
      });

      REQUIRE(colours.empty() == wanted.empty());
      std::map<unsigned, Colour> walked;
      colours.for_each([&](unsigned voxel, const Colour& c) { walked[voxel] = c; });
      REQUIRE(walked == wanted);
      const auto any = static_cast<unsigned>(rng() % kBrickVoxels);
      REQUIRE(colours.at(any) == (wanted.count(any) != 0 ? wanted[any] : Colour{}));
      bool same = wanted.size() == kBrickVoxels;
      for (const auto& [voxel, c] : wanted) same = same && c == wanted.begin()->second;
      REQUIRE(colours.uniform().has_value() == same);
    }
  }
}

TEST_CASE("colours shared by all voxels equal the same colours held one by one", "[octree]") {
  Colour red;
  red.add({255, 0, 0});
  const BrickColours shared(red);
  BrickColours single;
  std::array<Rgb, kBrickVoxels> seen{};
  seen.fill({255, 0, 0});
  single.add(kAllVoxels, seen);
  REQUIRE(shared == single);
  REQUIRE(single == shared);
  seen[77] = {254, 0, 0};
  BrickColours other;
  other.add(kAllVoxels, seen);
  REQUIRE_FALSE(shared == other);
}

}  // namespace
}  // namespace voxatlas
