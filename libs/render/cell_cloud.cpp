#include "render/cell_cloud.hpp"

#include <algorithm>

#include "base/check.hpp"

namespace voxatlas {
namespace {

/// Which cells of one depth are occupied, a bit each; coarser leaves fill all cells they cover.
class OccupiedCells {
 public:
  explicit OccupiedCells(int depth) : shift_(kDepth - depth), edge_(1u << depth) {
    bits_.resize((std::size_t{edge_} * edge_ * edge_ + 63) / 64);
  }

  void insert(CellKey cell) {
    const auto [min, size] = place(cell);
    for (std::uint32_t z = min[2]; z < min[2] + size; ++z) {
      for (std::uint32_t y = min[1]; y < min[1] + size; ++y) {
        for (std::uint32_t x = min[0]; x < min[0] + size; ++x) {
          const std::size_t at = index({x, y, z});
          bits_[at / 64] |= std::uint64_t{1} << at % 64;
        }
      }
    }
  }

  /// True where every cell that touches a face of `cell` is occupied. The tile's faces are open.
  bool surround(CellKey cell) const {
    const auto [min, size] = place(cell);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (min[axis] == 0 || min[axis] + size == edge_) return false;
      if (!layer_full(min, size, axis, min[axis] - 1)) return false;
      if (!layer_full(min, size, axis, min[axis] + size)) return false;
    }
    return true;
  }

 private:
  struct Place {
    Index3 min;
    std::uint32_t size;
  };

  Place place(CellKey cell) const {
    const Index3 voxel = cell.min_voxel();
    return {{voxel[0] >> shift_, voxel[1] >> shift_, voxel[2] >> shift_},
            cell.edge_voxels() >> shift_};
  }

  std::size_t index(const Index3& at) const {
    return (std::size_t{at[2]} * edge_ + at[1]) * edge_ + at[0];
  }

  bool holds(const Index3& at) const {
    const std::size_t i = index(at);
    return (bits_[i / 64] >> i % 64 & 1u) != 0;
  }

  /// The square of cells beside a face: `layer` on `axis`, the cell's own extent on the others.
  bool layer_full(const Index3& min, std::uint32_t size, std::size_t axis,
                  std::uint32_t layer) const {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    Index3 at{};
    at[axis] = layer;
    for (std::uint32_t i = 0; i < size; ++i) {
      for (std::uint32_t j = 0; j < size; ++j) {
        at[u] = min[u] + i;
        at[v] = min[v] + j;
        if (!holds(at)) return false;
      }
    }
    return true;
  }

  int shift_;
  std::uint32_t edge_;
  std::vector<std::uint64_t> bits_;
};

DrawnCell drawn(const Leaf& leaf) {
  const Index3 min = leaf.cell.min_voxel();
  DrawnCell cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell.centre[axis] = static_cast<std::int16_t>(2 * min[axis] + leaf.cell.edge_voxels());
  }
  cell.log_odds = leaf.state.log_odds;
  cell.depth = leaf.cell.depth & 0x7f;
  if (leaf.state.colour.exists()) {
    cell.rgb = leaf.state.colour.rgb();
    cell.coloured = 1;
  }
  return cell;
}

}  // namespace

CellCloud::CellCloud(const TileTree& tree, int depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  OccupiedCells occupied(depth);
  std::vector<Leaf> leaves;
  tree.for_each_cell(depth, [&](const Leaf& leaf) {
    if (!is_occupied(leaf.state.log_odds)) return;
    occupied.insert(leaf.cell);
    leaves.push_back(leaf);
  });
  std::erase_if(leaves, [&](const Leaf& leaf) { return occupied.surround(leaf.cell); });
  std::stable_sort(leaves.begin(), leaves.end(),
                   [](const Leaf& a, const Leaf& b) { return a.cell.depth < b.cell.depth; });
  cells_.reserve(leaves.size());
  for (const Leaf& leaf : leaves) cells_.push_back(drawn(leaf));
  for (std::size_t d = 0; d < begin_.size(); ++d) {
    const auto first =
        std::lower_bound(cells_.begin(), cells_.end(), d,
                         [](const DrawnCell& c, std::size_t of) { return c.depth < of; });
    begin_[d] = static_cast<std::uint32_t>(first - cells_.begin());
  }
}

std::span<const DrawnCell> CellCloud::cells_of_depth(int depth) const {
  const auto d = static_cast<std::size_t>(depth);
  return cells().subspan(begin_[d], begin_[d + 1] - begin_[d]);
}

}  // namespace voxatlas
