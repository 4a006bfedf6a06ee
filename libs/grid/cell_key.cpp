#include "grid/cell_key.hpp"

namespace voxatlas {

CellKey CellKey::of_voxel(const Index3& voxel, int depth) {
  const int shift = kDepth - depth;
  const Index3 cell{voxel[0] >> shift, voxel[1] >> shift, voxel[2] >> shift};
  return {static_cast<std::uint8_t>(depth), static_cast<std::uint32_t>(morton_encode(cell))};
}

Index3 CellKey::min_voxel() const {
  const int shift = kDepth - depth;
  const Index3 cell = morton_decode(code);
  return {cell[0] << shift, cell[1] << shift, cell[2] << shift};
}

}  // namespace voxatlas
