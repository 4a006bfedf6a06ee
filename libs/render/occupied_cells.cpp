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

/// The axis along which a cloud of points spreads least. Its spread's adjugate has the same axes,
/// and there that one is the longest by far where the points lie in a plane: squaring leaves little
/// else. Points on a line have none: then whatever is across it.
Eigen::Vector3f thinnest_axis(const Eigen::Matrix3f& spread) {
  const Eigen::Vector3f a = spread.col(0), b = spread.col(1), c = spread.col(2);
  Eigen::Matrix3f adjugate;
  adjugate << b.cross(c), c.cross(a), a.cross(b);
  constexpr float kOnALine = 1e-3f;
  constexpr int kSquarings = 6;
  for (int i = 0; i < kSquarings; ++i) {
    const float trace = adjugate.trace();
    if (!(trace > kOnALine)) {
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;  // Ascending.
      axes.computeDirect(spread);
      return axes.eigenvectors().col(0);
    }
    adjugate /= trace;
    adjugate = (adjugate * adjugate).eval();
  }
  Eigen::Index longest = 0;
  adjugate.diagonal().maxCoeff(&longest);
  return adjugate.col(longest).normalized();
}

}  // namespace

OccupiedCells::OccupiedCells(int depth)
    : shift_(kDepth - depth),
      edge_(1 << depth),
      words_((static_cast<std::size_t>(edge_) + 2 * kMargin + 63) / 64) {
  const auto rows = static_cast<std::size_t>(edge_ + 2 * kMargin);
  bits_.resize(rows * rows * words_ + 1);
}

OccupiedCells::Place OccupiedCells::place(CellKey cell) const {
  const Index3 voxel = cell.min_voxel();
  return {
      Eigen::Vector3i(static_cast<int>(voxel[0] >> shift_), static_cast<int>(voxel[1] >> shift_),
                      static_cast<int>(voxel[2] >> shift_)),
      static_cast<int>(cell.edge_voxels() >> shift_)};
}

void OccupiedCells::insert(const Eigen::Vector3i& min, int size) {
  const Eigen::Array3i from = min.array().max(-kMargin);
  const Eigen::Array3i to = (min.array() + size).min(edge_ + kMargin);  // Past the last.
  if ((from >= to).any()) return;
  const auto first = static_cast<std::size_t>(from.x() + kMargin);
  const auto last = static_cast<std::size_t>(to.x() + kMargin) - 1;
  const std::uint64_t head = ~std::uint64_t{0} << first % 64;
  const std::uint64_t tail = ~std::uint64_t{0} >> (63 - last % 64);
  for (int z = from.z(); z < to.z(); ++z) {
    for (int y = from.y(); y < to.y(); ++y) {
      std::uint64_t* words = bits_.data() + row(y, z);
      if (first / 64 == last / 64) {
        words[first / 64] |= head & tail;
        continue;
      }
      words[first / 64] |= head;
      std::fill(words + first / 64 + 1, words + last / 64, ~std::uint64_t{0});
      words[last / 64] |= tail;
    }
  }
}

bool OccupiedCells::surround(CellKey cell) const {
  const Place at = place(cell);
  for (int axis = 0; axis < 3; ++axis) {
    if (!layer_full(at, axis, at.min[axis] - 1)) return false;
    if (!layer_full(at, axis, at.min[axis] + at.size)) return false;
  }
  return true;
}

bool OccupiedCells::layer_full(const Place& cell, int axis, int layer) const {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  Eigen::Vector3i at;
  at[axis] = layer;
  for (int i = 0; i < cell.size; ++i) {
    for (int j = 0; j < cell.size; ++j) {
      at[u] = cell.min[u] + i;
      at[v] = cell.min[v] + j;
      if (!holds(at)) return false;
    }
  }
  return true;
}

unsigned OccupiedCells::row_of_five(int x, int y, int z) const {
  const auto bit = static_cast<std::size_t>(x - 2 + kMargin);
  const std::uint64_t* words = bits_.data() + row(y, z) + bit / 64;
  std::uint64_t bits = words[0] >> bit % 64;
  if (bit % 64 > 59) bits |= words[1] << (64 - bit % 64);
  return static_cast<unsigned>(bits & 0x1f);
}

Eigen::Vector3f OccupiedCells::normal(CellKey cell) const {
  const Place at = place(cell);
  return at.size == 1 ? normal(at.min) : Eigen::Vector3f::Zero();
}

Eigen::Vector3f OccupiedCells::normal(const Eigen::Vector3i& at) const {
  int count = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (int dz = -2; dz <= 2; ++dz) {
    int layer = 0, layer_x = 0, layer_y = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      const RowSums row = kRowSums[row_of_five(at.x(), at.y() + dy, at.z() + dz)];
      layer += row.count;
      layer_x += row.x;
      layer_y += row.count * dy;
      xx += row.xx;
      xy += row.x * dy;
      yy += row.count * dy * dy;
    }
    count += layer;
    x += layer_x;
    y += layer_y;
    z += layer * dz;
    xz += layer_x * dz;
    yz += layer_y * dz;
    zz += layer * dz * dz;
  }
  if (count < kFewest) return Eigen::Vector3f::Zero();
  Eigen::Matrix3i products;
  products << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  const auto n = static_cast<float>(count);
  const Eigen::Vector3f mean = Eigen::Vector3i(x, y, z).cast<float>() / n;
  return thinnest_axis(products.cast<float>() / n - mean * mean.transpose());
}

}  // namespace voxatlas
