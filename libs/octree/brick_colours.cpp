#include "octree/brick_colours.hpp"

#include <algorithm>
#include <bit>

namespace voxatlas {
namespace {

VoxelMask either(const VoxelMask& a, const VoxelMask& b) {
  VoxelMask result;
  for (std::size_t z = 0; z < 8; ++z) result[z] = a[z] | b[z];
  return result;
}

VoxelMask without(const VoxelMask& a, const VoxelMask& b) {
  VoxelMask result;
  for (std::size_t z = 0; z < 8; ++z) result[z] = a[z] & ~b[z];
  return result;
}

bool all_equal(const std::vector<Colour>& colours) {
  return std::adjacent_find(colours.begin(), colours.end(), std::not_equal_to<>()) == colours.end();
}

}  // namespace

Colour BrickColours::at(unsigned voxel) const {
  if (!has_voxel(voxels_, voxel)) return {};
  if (colours_.size() == 1) return colours_[0];
  std::size_t rank = 0;
  for (std::size_t z = 0; z < voxel >> 6; ++z) {
    rank += static_cast<std::size_t>(std::popcount(voxels_[z]));
  }
  const std::uint64_t below = (std::uint64_t{1} << (voxel & 63)) - 1;
  return colours_[rank + static_cast<std::size_t>(std::popcount(voxels_[voxel >> 6] & below))];
}

std::optional<Colour> BrickColours::uniform() const {
  if (voxels_ != kAllVoxels || !all_equal(colours_)) return std::nullopt;
  return colours_[0];
}

void BrickColours::add(const VoxelMask& voxels, std::span<const Rgb> seen) {
  const VoxelMask all = either(voxels_, voxels);
  if (all == voxels_ && colours_.size() > 1) return add_in_place(voxels, seen);
  std::vector<Colour> merged;
  merged.reserve(count_of(all));
  std::size_t next = 0;
  for_each_bit(all, [&](unsigned voxel) {
    merged.emplace_back();
    if (has_voxel(voxels_, voxel)) {
      merged.back() = colours_[next];
      if (colours_.size() > 1) ++next;
    }
    if (has_voxel(voxels, voxel)) merged.back().add(seen[voxel]);
  });
  voxels_ = all;
  colours_ = std::move(merged);
}

/// The voxels have colours of their own already, as most do that are seen once more.
void BrickColours::add_in_place(const VoxelMask& voxels, std::span<const Rgb> seen) {
  auto next = colours_.begin();
  for (std::size_t z = 0; z < 8; ++z) {
    for (std::uint64_t left = voxels_[z]; left != 0; left &= left - 1, ++next) {
      const std::uint64_t bit = left & -left;
      if ((voxels[z] & bit) == 0) continue;
      next->add(seen[64 * z + static_cast<std::size_t>(std::countr_zero(bit))]);
    }
  }
}

void BrickColours::assign(const VoxelMask& voxels, const Colour& colour) {
  const VoxelMask all = either(voxels_, voxels);
  std::vector<Colour> merged;
  merged.reserve(count_of(all));
  std::size_t next = 0;
  for_each_bit(all, [&](unsigned voxel) {
    const std::size_t own = next;
    if (has_voxel(voxels_, voxel) && colours_.size() > 1) ++next;
    merged.push_back(has_voxel(voxels, voxel) ? colour : colours_[own]);
  });
  voxels_ = all;
  colours_ = std::move(merged);
}

void BrickColours::remove(const VoxelMask& voxels) {
  const VoxelMask left = without(voxels_, voxels);
  if (left == voxels_) return;
  if (!any_of(left)) {
    *this = {};
    return;
  }
  if (colours_.size() > 1) {
    std::size_t next = 0, kept = 0;
    for_each_bit(voxels_, [&](unsigned voxel) {
      if (has_voxel(left, voxel)) colours_[kept++] = colours_[next];
      ++next;
    });
    colours_.resize(kept);
  }
  voxels_ = left;
}

bool operator==(const BrickColours& a, const BrickColours& b) {
  if (a.voxels_ != b.voxels_) return false;
  if (a.colours_.size() == b.colours_.size()) return a.colours_ == b.colours_;
  return all_equal(a.colours_) && all_equal(b.colours_) && a.colours_[0] == b.colours_[0];
}

}  // namespace voxatlas
