#include "octree/tile_hash.hpp"

#include <catch2/catch.hpp>

#include "base/bytes.hpp"
#include "support/dense_tile.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

/// Oracle: FORMAT.md's stream in one piece, from the dense array's leaves.
Sha256Digest hash_by_format(TileKey key, const test::DenseTile& dense) {
  Bytes stream;
  ByteWriter out(stream);
  out.put(key.morton());
  for (const Leaf& leaf : dense.leaves()) {
    out.put(leaf.cell.depth);
    out.put(leaf.cell.code);
    out.put(leaf.state.log_odds);
    out.put(static_cast<std::uint8_t>(leaf.state.colour.count));
    if (leaf.state.colour.count == 0) continue;
    for (const auto channel : leaf.state.colour.mean) out.put(channel);
  }
  return sha256(stream);
}

TEST_CASE("a tile's hash is that of its canonical leaves", "[octree][oracle]") {
  const auto key = TileKey::from_index({500'001, 499'999, 3}).value();
  test::RandomOctree random(77);
  TileTree tree;
  test::DenseTile dense;
  REQUIRE(tile_hash(key, tree) == hash_by_format(key, dense));
  for (int i = 0; i < 150; ++i) {
    const CellKey cell = random.cell();
    const auto seen = random.maybe_colour();
    tree.hit(cell, random.model(), seen);
    dense.hit(cell, random.model(), seen);
    const TileDelta delta = random.delta();
    tree.apply(delta, random.model());
    dense.apply(delta, random.model());
  }
  REQUIRE(tree.counts().leaves > 8000);  // More than one piece.
  REQUIRE(tile_hash(key, tree) == hash_by_format(key, dense));
}

TEST_CASE("the golden tile keeps its hash", "[octree][golden]") {
  const auto key = TileKey::from_morton(0x123456789abcdef).value();
  TileTree tree;
  const SensorModel model = SensorModel::standard();
  tree.miss({2, 13}, model);
  tree.miss({4, 13 * 64 + 5}, model);
  tree.hit({7, 1'000'000}, model, Rgb{10, 200, 255});
  tree.hit({7, 1'000'000}, model, Rgb{11, 100, 255});
  tree.hit({5, 40}, model);
  REQUIRE(to_hex(tile_hash(key, {})) ==
          "a85ba2b36261d0dca4b6cbbc840fa8a441ec95200abba5c5623e7ddadeff99e5");
  REQUIRE(to_hex(tile_hash(key, tree)) ==
          "7388beb450ef501512e2796a67f56a9e12b0e4b2ec44e01ddf08334705f8c269");
}

TEST_CASE("a hash tells apart what differs in place, key, log-odds or colour alone", "[octree]") {
  const auto key = TileKey::from_morton(5).value(), other_key = TileKey::from_morton(6).value();
  TileTree tree, elsewhere, fainter, coloured;
  tree.set({7, 99}, {100, {}});
  elsewhere.set({7, 98}, {100, {}});
  fainter.set({7, 99}, {99, {}});
  coloured.set({7, 99}, {100, {{1, 2, 3}, 1}});
  const auto hash = tile_hash(key, tree);
  REQUIRE(hash != tile_hash(other_key, tree));
  REQUIRE(hash != tile_hash(key, elsewhere));
  REQUIRE(hash != tile_hash(key, fainter));
  REQUIRE(hash != tile_hash(key, coloured));
  TileTree same_by_other_ways;
  same_by_other_ways.set({3, 0}, {100, {}});
  same_by_other_ways.erase({0, 0});
  same_by_other_ways.set({6, 12}, {100, {}});
  for (std::uint32_t code = 96; code < 104; ++code) {
    if (code != 99) same_by_other_ways.erase({7, code});
  }
  REQUIRE(hash == tile_hash(key, same_by_other_ways));
}

}  // namespace
}  // namespace voxatlas
