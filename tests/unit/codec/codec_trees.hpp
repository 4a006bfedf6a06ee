#pragma once

#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas::test {

/// Any tile at all: log-odds anywhere, colours, big cells and voxels.
inline TileTree random_tree(RandomOctree& random) {
  TileTree tree;
  for (auto count = random.below(60); count > 0; --count) tree.set(random.cell(), random.state());
  for (auto count = random.below(4); count > 0; --count) tree.apply(random.delta(), random.model());
  return tree;
}

/// A tile as scans leave it: updates only.
inline TileTree scanned_tree(RandomOctree& random) {
  TileTree tree;
  for (auto count = 1 + random.below(8); count > 0; --count) {
    tree.apply(random.delta(), random.model());
  }
  return tree;
}

/// The tile of the golden files, a bit of everything.
inline TileTree golden_tree() {
  const auto model = SensorModel::standard();
  TileTree tree;
  tree.set(CellKey{1, 3}, {-3000, {}});
  for (std::uint32_t code = 0; code < 4096; code += 37) tree.miss(CellKey{4, code}, model);
  for (std::uint32_t code = 1000; code < 60'000; code += 71) {
    const auto shade = static_cast<std::uint8_t>(code);
    tree.hit(CellKey{kDepth, code}, model);
    if (code % 2 == 0) tree.hit(CellKey{kDepth, code}, model, Rgb{shade, 90, 17});
  }
  tree.hit(CellKey{6, 200'000}, model, Rgb{255, 255, 255});
  return tree;
}

}  // namespace voxatlas::test
