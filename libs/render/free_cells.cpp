#include "render/free_cells.hpp"

#include <bit>
#include <map>

#include "base/check.hpp"

namespace voxatlas {
namespace {

/// The tile beside one along an axis, on a side; nullptr where it is not among them.
class Neighbours {
 public:
  explicit Neighbours(std::span<const PlacedFree> tiles) {
    for (const PlacedFree& placed : tiles) by_index_[placed.key.index()] = placed.cells;
  }
  const FreeCells* beside(TileKey key, std::size_t axis, bool upper) const {
    Index3 index = key.index();
    index[axis] += upper ? 1u : ~0u;  // Off the cube there is no tile of that index.
    const auto found = by_index_.find(index);
    return found == by_index_.end() ? nullptr : found->second;
  }

 private:
  std::map<Index3, const FreeCells*> by_index_;
};

template <class Visit>
void each_cell(const FreeCells& cells, const Visit& visit) {
  Eigen::Vector3i at;
  for (at.z() = 0; at.z() < cells.edge(); ++at.z()) {
    for (at.y() = 0; at.y() < cells.edge(); ++at.y()) {
      for (at.x() = 0; at.x() < cells.edge(); ++at.x()) {
        if (cells.holds(at)) visit(at);
      }
    }
  }
}

}  // namespace

FreeCells::FreeCells(const TileTree& tree, int depth) : depth_(depth) {
  VOX_CHECK(depth >= 0 && depth <= kDepth);
  bits_.resize(((std::size_t{1} << 3 * depth) + 63) / 64);
  tree.for_each_cell(depth, [&](const Leaf& leaf) {
    if (is_occupied(leaf.state.log_odds)) return;
    const int shift = kDepth - depth;
    const Index3 voxel = leaf.cell.min_voxel();
    const int size = static_cast<int>(leaf.cell.edge_voxels()) >> shift;
    const Eigen::Vector3i min(static_cast<int>(voxel[0] >> shift),
                              static_cast<int>(voxel[1] >> shift),
                              static_cast<int>(voxel[2] >> shift));
    for (int z = 0; z < size; ++z) {
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          const std::size_t i = index(min + Eigen::Vector3i(x, y, z));
          bits_[i / 64] |= std::uint64_t{1} << i % 64;
        }
      }
    }
  });
}

std::size_t FreeCells::count() const {
  std::size_t count = 0;
  for (const std::uint64_t word : bits_) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

std::vector<std::vector<FreeFace>> bounding_faces(std::span<const PlacedFree> tiles) {
  const Neighbours neighbours(tiles);
  std::vector<std::vector<FreeFace>> faces;
  for (const PlacedFree& placed : tiles) {
    VOX_CHECK(placed.cells->depth() == tiles.front().cells->depth());
    std::vector<FreeFace>& own = faces.emplace_back();
    const int edge = placed.cells->edge();
    each_cell(*placed.cells, [&](const Eigen::Vector3i& cell) {
      for (std::uint8_t axis = 0; axis < 3; ++axis) {
        for (const bool upper : {false, true}) {
          Eigen::Vector3i at = cell;
          at[axis] += upper ? 1 : -1;
          const FreeCells* there = placed.cells;
          if (at[axis] < 0 || at[axis] >= edge) {
            there = neighbours.beside(placed.key, axis, upper);
            at[axis] = upper ? 0 : edge - 1;
          }
          if (there == nullptr || !there->holds(at)) own.push_back({cell, axis, upper});
        }
      }
    });
  }
  return faces;
}

}  // namespace voxatlas
