#include "codec/node_stream.hpp"

#include <fmt/format.h>

#include "codec/leaf_values.hpp"
#include "codec/node_structure.hpp"

namespace voxatlas {

Bytes encode_nodes(const TileTree& tree) {
  const auto leaves = tree.leaves();
  const auto masks = masks_of(leaves);
  Bytes bytes;
  ByteWriter out(bytes);
  out.put(static_cast<std::uint8_t>(masks.root));
  if (masks.root == NodeMasks::Root::kNone) return bytes;
  if (masks.root == NodeMasks::Root::kInner) {
    out.put_varint(masks.child_masks.size());
    out.put_varint(masks.leaf_masks.size());
    out.put_bytes(masks.child_masks);
    out.put_bytes(masks.leaf_masks);
  }
  write_log_odds(leaves, out);
  write_colours(leaves, out);
  return bytes;
}

static Result<LeafCells> read_structure(ByteReader& in) {
  const auto root = in.get<std::uint8_t>();
  if (root > static_cast<std::uint8_t>(NodeMasks::Root::kInner)) {
    return fail(ErrorCode::kCorrupt, fmt::format("tile: root kind {}, not 0..2", root));
  }
  const auto kind = static_cast<NodeMasks::Root>(root);
  ByteView child_masks;
  ByteView leaf_masks;
  if (kind == NodeMasks::Root::kInner) {
    const auto children = in.get_varint();
    const auto leaves = in.get_varint();
    child_masks = in.get_bytes(children);
    leaf_masks = in.get_bytes(leaves);
  }
  if (!in.ok()) return fail(ErrorCode::kCorrupt, "tile: node masks: too short");
  return leaves_of(kind, child_masks, leaf_masks);
}

/// Eight equal children would have been pruned into their parent.
static bool is_pruned(const LeafCells& leaves, std::span<const CellState> states) {
  for (const auto first : leaves.full_parents) {
    const auto eight = states.subspan(first, 8);
    std::size_t alike = 1;
    while (alike < 8 && eight[alike] == eight[0]) ++alike;
    if (alike == 8) return false;
  }
  return true;
}

Result<TileTree> decode_nodes(ByteView bytes) {
  ByteReader in(bytes);
  auto leaves = read_structure(in);
  if (!leaves) return pass_on(leaves);
  TileTree tree;
  std::vector<CellState> states(leaves->cells.size());
  if (!states.empty()) {
    if (auto ok = read_log_odds(in, states); !ok) return pass_on(ok);
    if (auto ok = read_colours(in, states); !ok) return pass_on(ok);
  }
  if (!in.at_end()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile: {} bytes, {} of them read", bytes.size(), in.position()));
  }
  if (!is_pruned(*leaves, states)) {
    return fail(ErrorCode::kCorrupt, "tile: eight equal children that were not pruned");
  }
  for (std::size_t i = 0; i < states.size(); ++i) tree.set(leaves->cells[i], states[i]);
  return tree;
}

std::uint64_t paper_lossless_bits(const TileTree::Counts& counts) {
  constexpr std::uint64_t kLeafBit = 1;
  constexpr std::uint64_t kProbability = 32;
  constexpr std::uint64_t kColour = 24;
  constexpr std::uint64_t kChildArray = 8;
  return counts.leaves * (kLeafBit + kProbability + kColour) +
         counts.inner * (kLeafBit + kChildArray);
}

}  // namespace voxatlas
