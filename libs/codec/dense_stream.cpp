#include "codec/dense_stream.hpp"

#include <fmt/format.h>

#include "base/check.hpp"
#include "codec/colour_model.hpp"
#include "codec/palette_code.hpp"
#include "codec/pyramid_model.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {

static constexpr std::size_t kMostValues = 65'535;

bool can_be_dense(const TileTree& tree) {
  if (tree.bricks() == nullptr) return true;
  // Only a tile that knows at least as many voxels as there are values can hold all of them, -8
  // among them, in mixed bricks.
  unsigned mixed = 0;
  for (unsigned i = 0; i < kBricks; ++i) mixed += tree.bricks()->is_mixed(i) ? 1 : 0;
  constexpr unsigned kTooFew = (kMostValues - kBricks) / kBrickVoxels;
  return mixed < kTooFew || places_fit(*tree.bricks());
}

Bytes encode_dense(const TileTree& tree) {
  Bytes bytes;
  if (tree.empty()) return bytes;
  Pyramid pyramid = pyramid_of(*tree.bricks());
  VOX_CHECK(pyramid.palette.size() <= kMostValues);
  RangeEncoder coder(bytes);
  code_palette(coder, pyramid.palette);
  PyramidModel model(coder, pyramid);
  TileColours colours = colours_of(*tree.bricks());
  ColourModel colour_model(coder, pyramid, colours);
  model.code_slots();
  colour_model.code_bricks();
  for (int depth = kBrickDepth + 1; depth <= kDepth; ++depth) model.code_depth(depth);
  colour_model.code_voxels();
  coder.finish();
  return bytes;
}

Result<TileTree> decode_dense(ByteView bytes, int depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  if (bytes.empty()) return TileTree();
  const auto broken = [&](const char* what) {
    return fail(ErrorCode::kCorrupt, fmt::format("tile: {} dense bytes: {}", bytes.size(), what));
  };
  RangeDecoder coder(bytes);
  Pyramid pyramid;
  if (!code_palette(coder, pyramid.palette)) return broken("their palette is none");
  PyramidModel model(coder, pyramid);
  TileColours colours;
  ColourModel colour_model(coder, pyramid, colours);
  model.code_slots();
  if (model.broken()) return broken("they contradict themselves");
  colour_model.code_bricks();
  for (int below = kBrickDepth + 1; below <= depth; ++below) model.code_depth(below);
  if (depth == kDepth && !model.broken()) colour_model.code_voxels();
  if (model.broken() || colour_model.broken()) return broken("they contradict themselves");
  if (depth == kDepth && !coder.at_end()) return broken("they do not end where the tile does");
  BrickTable table = bricks_of(pyramid, depth);
  if (!colours.bricks.empty()) paint(colours, depth, table);
  return TileTree::of_bricks(std::move(table));
}

}  // namespace voxatlas
