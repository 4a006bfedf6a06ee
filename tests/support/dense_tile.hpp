#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "octree/tile_delta.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::test {

/// The oracle of TileTree: 128^3 voxels in one plain array, every rule written as a loop over
/// voxels. Slow, large (23 MB) and obvious.
class DenseTile {
 public:
  DenseTile();

  void hit(CellKey cell, const SensorModel& model, std::optional<Rgb> seen = std::nullopt);
  void miss(CellKey cell, const SensorModel& model);
  void apply(const TileDelta& delta, const SensorModel& model);
  void set(CellKey cell, const CellState& state);
  void erase(CellKey cell);

  std::optional<CellState> voxel(const Index3& voxel) const;
  std::optional<CellState> cell(CellKey cell) const;
  std::optional<CellState> uniform(CellKey cell) const;
  /// As TileTree::for_each_cell; the canonical leaves where depth is 7.
  std::vector<Leaf> cells(int depth) const;
  std::vector<Leaf> leaves() const { return cells(kDepth); }
  TileTree::Counts counts() const;

 private:
  struct Voxel {
    bool known = false;
    CellState state;
  };

  Voxel& at(const Index3& voxel) {
    return voxels_[(voxel[2] * kTileVoxels + voxel[1]) * kTileVoxels + voxel[0]];
  }
  const Voxel& at(const Index3& voxel) const { return const_cast<DenseTile*>(this)->at(voxel); }
  void for_each_voxel(CellKey cell, const std::function<void(Voxel&)>& change);
  void collect(CellKey cell, int depth, std::vector<Leaf>& out, std::uint64_t& inner) const;

  std::vector<Voxel> voxels_;
};

/// The first difference between tree and oracle in words, empty where there is none: every voxel,
/// the canonical leaves, the cells at every depth, the counts.
std::string difference(const TileTree& tree, const DenseTile& dense);

}  // namespace voxatlas::test
