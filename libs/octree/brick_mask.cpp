#include "octree/brick_mask.hpp"

namespace voxatlas {
namespace {

/// One layer (z) of a cell at the origin of its brick, by depth - 4.
constexpr std::array<std::uint64_t, 4> kCellLayer{~0ull, 0x0f0f0f0full, 0x0303ull, 0x1ull};

constexpr VoxelMask every(std::uint64_t layer, std::size_t step) {
  VoxelMask mask{};
  for (std::size_t z = 0; z < 8; z += step) mask[z] = layer;
  return mask;
}

constexpr std::array<VoxelMask, 4> kLowest{every(0x1ull, 8), every(0x0000001100000011ull, 4),
                                           every(0x0055005500550055ull, 2), kAllVoxels};

}  // namespace

VoxelMask cell_voxels(unsigned lowest_voxel, int depth) {
  const std::uint64_t layer = kCellLayer[static_cast<std::size_t>(depth - kBrickDepth)]
                              << (lowest_voxel & 63);
  const unsigned first = lowest_voxel >> 6;
  VoxelMask mask{};
  for (unsigned z = first; z < first + (1u << (kDepth - depth)); ++z) mask[z] = layer;
  return mask;
}

const VoxelMask& lowest_voxels(int depth) {
  return kLowest[static_cast<std::size_t>(depth - kBrickDepth)];
}

}  // namespace voxatlas
