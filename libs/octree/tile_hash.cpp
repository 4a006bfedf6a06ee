#include "octree/tile_hash.hpp"

#include "base/bytes.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kPiece = 64 * 1024;

void put_leaf(const Leaf& leaf, ByteWriter& out) {
  out.put(leaf.cell.depth);
  out.put(leaf.cell.code);
  out.put(leaf.state.log_odds);
  out.put(static_cast<std::uint8_t>(leaf.state.colour.count));
  if (!leaf.state.colour.exists()) return;
  for (const auto channel : leaf.state.colour.mean) out.put(channel);
}

}  // namespace

Sha256Digest tile_hash(TileKey key, const TileTree& tree) {
  Sha256 hash;
  Bytes piece;
  piece.reserve(kPiece + 64);
  ByteWriter writer(piece);
  writer.put(key.morton());
  tree.for_each_leaf([&](const Leaf& leaf) {
    put_leaf(leaf, writer);
    if (piece.size() < kPiece) return;
    hash.update(piece);
    piece.clear();
  });
  hash.update(piece);
  return hash.finish();
}

}  // namespace voxatlas
