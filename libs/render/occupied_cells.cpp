#include "render/occupied_cells.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace voxatlas {
namespace {

/// Sums over the set bits of a row of five, at -2 .. 2.
struct RowSums {
  int count, x, xx;
};

constexpr std::array<RowSums, 32> kRowSums = [] {
  std::array<RowSums, 32> table{};
  for (unsigned row = 0; row < 32; ++row) {
    for (int bit = 0; bit < 5; ++bit) {
      if ((row >> bit & 1u) == 0) continue;
      const int x = bit - 2;
      table[row].count += 1;
      table[row].x += x;
      table[row].xx += x * x;
    }
  }
  return table;
}();

}  // namespace

OccupiedCells::OccupiedCells(int depth) : shift_(kDepth - depth), edge_(1u << depth) {
  bits_.resize((std::size_t{edge_} * edge_ * edge_ + 63) / 64 + 1);
}

OccupiedCells::Place OccupiedCells::place(CellKey cell) const {
  const Index3 voxel = cell.min_voxel();
  return {{voxel[0] >> shift_, voxel[1] >> shift_, voxel[2] >> shift_},
          cell.edge_voxels() >> shift_};
}

void OccupiedCells::insert(CellKey cell) {
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

bool OccupiedCells::surround(CellKey cell) const {
  const Place at = place(cell);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (at.min[axis] == 0 || at.min[axis] + at.size == edge_) return false;
    if (!layer_full(at, axis, at.min[axis] - 1)) return false;
    if (!layer_full(at, axis, at.min[axis] + at.size)) return false;
  }
  return true;
}

bool OccupiedCells::layer_full(const Place& cell, std::size_t axis, std::uint32_t layer) const {
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  Index3 at{};
  at[axis] = layer;
  for (std::uint32_t i = 0; i < cell.size; ++i) {
    for (std::uint32_t j = 0; j < cell.size; ++j) {
      at[u] = cell.min[u] + i;
      at[v] = cell.min[v] + j;
      if (!holds(at)) return false;
    }
  }
  return true;
}

unsigned OccupiedCells::row_of_five(int x, int y, int z) const {
  const int edge = static_cast<int>(edge_);
  if (y < 0 || z < 0 || y >= edge || z >= edge) return 0;
  const int first = std::max(0, x - 2);
  const int last = std::min(edge - 1, x + 2);
  const std::size_t at = index({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(y),
                                static_cast<std::uint32_t>(z)});
  std::uint64_t bits = bits_[at / 64] >> at % 64;
  if (at % 64 != 0) bits |= bits_[at / 64 + 1] << (64 - at % 64);
  const auto row = static_cast<unsigned>(bits & ((1u << (last - first + 1)) - 1));
  return row << (first - (x - 2));
}

Eigen::Vector3f OccupiedCells::normal(CellKey cell) const {
  const auto [min, size] = place(cell);
  if (size != 1) return Eigen::Vector3f::Zero();
  const Eigen::Vector3i at(static_cast<int>(min[0]), static_cast<int>(min[1]),
                           static_cast<int>(min[2]));
  int count = 0;
  Eigen::Vector3i sum = Eigen::Vector3i::Zero();
  Eigen::Matrix3i products = Eigen::Matrix3i::Zero();
  for (int dz = -2; dz <= 2; ++dz) {
    for (int dy = -2; dy <= 2; ++dy) {
      const RowSums row = kRowSums[row_of_five(at.x(), at.y() + dy, at.z() + dz)];
      count += row.count;
      sum += Eigen::Vector3i(row.x, row.count * dy, row.count * dz);
      products(0, 0) += row.xx;
      products(1, 0) += row.x * dy;
      products(2, 0) += row.x * dz;
      products(1, 1) += row.count * dy * dy;
      products(2, 1) += row.count * dy * dz;
      products(2, 2) += row.count * dz * dz;
    }
  }
  if (count < kFewest) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f mean = sum.cast<float>() / static_cast<float>(count);
  const Eigen::Matrix3f spread =
      products.cast<float>() / static_cast<float>(count) - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;  // Reads the lower triangle; ascending.
  axes.computeDirect(spread);
  return axes.eigenvectors().col(0);
}

}  // namespace voxatlas
