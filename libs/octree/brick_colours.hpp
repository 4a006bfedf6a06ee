#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octree/brick_mask.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

/// The colours of one brick: which voxels have one, and one for each of these in voxel order, or a
/// single one that all of them share. Never a Colour that does not exist.
class BrickColours {
 public:
  BrickColours() = default;
  /// Every voxel of the brick has this colour.
  explicit BrickColours(const Colour& colour) : voxels_(kAllVoxels), colours_{colour} {}
  /// One colour for each voxel of the mask, in voxel order.
  BrickColours(const VoxelMask& voxels, std::vector<Colour> colours)
      : voxels_(voxels), colours_(std::move(colours)) {}

  bool empty() const { return colours_.empty(); }
  const VoxelMask& voxels() const { return voxels_; }
  /// Colour{} where the voxel has none.
  Colour at(unsigned voxel) const;
  /// The colour of all 512 voxels, where they have the same one.
  std::optional<Colour> uniform() const;
  /// Calls visit(voxel number, colour) in voxel order.
  template <class Visit>
  void for_each(Visit visit) const {
    std::size_t next = 0;
    for_each_bit(voxels_, [&](unsigned voxel) {
      visit(voxel, colours_[next]);
      if (colours_.size() > 1) ++next;
    });
  }

  /// Colour::add for each voxel of the mask; `seen` has 512 entries, read at those voxels only.
  void add(const VoxelMask& voxels, std::span<const Rgb> seen);
  /// Gives the voxels of the mask this colour, in place of what they had.
  void assign(const VoxelMask& voxels, const Colour& colour);
  void remove(const VoxelMask& voxels);

  std::size_t memory_bytes() const { return sizeof *this + colours_.capacity() * sizeof(Colour); }

  friend bool operator==(const BrickColours& a, const BrickColours& b);

 private:
  void add_in_place(const VoxelMask& voxels, std::span<const Rgb> seen);

  VoxelMask voxels_{};
  std::vector<Colour> colours_;  ///< One for each set bit, or one for all of them.
};

}  // namespace voxatlas
