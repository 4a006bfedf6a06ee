#include "render/occupied_cells.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

namespace voxatlas {
namespace {

/// Three sums in one number: one addition adds all three.
struct Packed {
  static constexpr std::int64_t of(int count, int x, int xx) {
    return count + x * (std::int64_t{1} << 16) + xx * (std::int64_t{1} << 32);
  }
  explicit Packed(std::int64_t sums)
      : count(static_cast<std::int16_t>(sums)),
        x(static_cast<std::int16_t>((sums - count) >> 16)),
        xx(static_cast<int>((sums - count - x * (std::int64_t{1} << 16)) >> 32)) {}
  int count, x, xx;
};

/// Of the set bits of a row of five, at -2 .. 2.
constexpr std::array<std::int64_t, 32> kRowSums = [] {
  std::array<std::int64_t, 32> table{};
  for (unsigned row = 0; row < 32; ++row) {
    for (int bit = 0; bit < 5; ++bit) {
      const int x = bit - 2;
      if ((row >> bit & 1u) != 0) table[row] += Packed::of(1, x, x * x);
    }
  }
  return table;
}();

/// Of five numbers that belong to -2 .. 2: their sum, and those of them times the first and the
/// second power of that.
struct Moments {
  std::int64_t zeroth, first, second;
  explicit Moments(const std::array<std::int64_t, 5>& at) {
    const std::int64_t outer = at[0] + at[4], inner = at[1] + at[3];
    zeroth = outer + inner + at[2];
    first = 2 * (at[4] - at[0]) + at[3] - at[1];
    second = 4 * outer + inner;
  }
};

using Lanes = std::array<float, OccupiedCells::kAtOnce>;

/// Symmetric matrices, a lane each.
struct Symmetric {
  Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
};

Eigen::Matrix3f lane_of(const Symmetric& m, std::size_t i) {
  Eigen::Matrix3f lane;
  lane << m.xx[i], m.xy[i], m.xz[i], m.xy[i], m.yy[i], m.yz[i], m.xz[i], m.yz[i], m.zz[i];
  return lane;
}

/// Divided by their traces and squared: one loop over the lanes, which compilers make SIMD of.
Symmetric squared(const Symmetric& m) {
  Symmetric square;
  for (std::size_t i = 0; i < OccupiedCells::kAtOnce; ++i) {
    const float scale = 1 / (m.xx[i] + m.yy[i] + m.zz[i]);
    const float xx = m.xx[i] * scale, xy = m.xy[i] * scale, xz = m.xz[i] * scale;
    const float yy = m.yy[i] * scale, yz = m.yz[i] * scale, zz = m.zz[i] * scale;
    square.xx[i] = xx * xx + xy * xy + xz * xz;
    square.xy[i] = xx * xy + xy * yy + xz * yz;
    square.xz[i] = xx * xz + xy * yz + xz * zz;
    square.yy[i] = xy * xy + yy * yy + yz * yz;
    square.yz[i] = xy * xz + yy * yz + yz * zz;
    square.zz[i] = xz * xz + yz * yz + zz * zz;
  }
  return square;
}

Symmetric adjugate_of(const Symmetric& m) {
  Symmetric adjugate;
  for (std::size_t i = 0; i < OccupiedCells::kAtOnce; ++i) {
    adjugate.xx[i] = m.yy[i] * m.zz[i] - m.yz[i] * m.yz[i];
    adjugate.xy[i] = m.xz[i] * m.yz[i] - m.xy[i] * m.zz[i];
    adjugate.xz[i] = m.xy[i] * m.yz[i] - m.xz[i] * m.yy[i];
    adjugate.yy[i] = m.xx[i] * m.zz[i] - m.xz[i] * m.xz[i];
    adjugate.yz[i] = m.xy[i] * m.xz[i] - m.xx[i] * m.yz[i];
    adjugate.zz[i] = m.xx[i] * m.yy[i] - m.xy[i] * m.xy[i];
  }
  return adjugate;
}

/// The axes along which clouds of points spread least. A spread's adjugate has the same axes, and
/// there that one is the longest by far where the points lie in a plane: squaring leaves little
/// else. Points on a line have none: then whatever is across it.
std::array<Eigen::Vector3f, OccupiedCells::kAtOnce> thinnest_axes(
    const Symmetric& spreads, const std::array<bool, OccupiedCells::kAtOnce>& wanted) {
  constexpr float kOnALine = 1e-3f;
  constexpr int kSquarings = 6;
  const Symmetric adjugates = adjugate_of(spreads);
  Symmetric powers = adjugates;
  for (int i = 0; i < kSquarings; ++i) powers = squared(powers);
  std::array<Eigen::Vector3f, OccupiedCells::kAtOnce> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!wanted[i]) continue;
    if (!(adjugates.xx[i] + adjugates.yy[i] + adjugates.zz[i] > kOnALine)) {
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;  // Ascending.
      solver.computeDirect(lane_of(spreads, i));
      axes[i] = solver.eigenvectors().col(0);
      continue;
    }
    const Eigen::Matrix3f power = lane_of(powers, i);
    Eigen::Index longest = 0;
    power.diagonal().maxCoeff(&longest);
    axes[i] = power.col(longest).normalized();
  }
  return axes;
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

OccupiedCells::Sums OccupiedCells::sums_around(const Eigen::Vector3i& at) const {
  const auto bit = static_cast<std::size_t>(at.x() - 2 + kMargin);
  const std::size_t shift = bit % 64;
  const std::size_t layer = words_ * static_cast<std::size_t>(edge_ + 2 * kMargin);
  const std::uint64_t* first = bits_.data() + row(at.y() - 2, at.z() - 2) + bit / 64;
  std::array<std::int64_t, 5> all, by_y, by_yy;
  for (std::size_t z = 0; z < 5; ++z) {
    std::array<std::int64_t, 5> rows;
    for (std::size_t y = 0; y < 5; ++y) {
      const std::uint64_t* words = first + z * layer + y * words_;
      std::uint64_t five = words[0] >> shift;
      if (shift > 59) five |= words[1] << (64 - shift);
      rows[y] = kRowSums[five & 0x1f];
    }
    const Moments moments(rows);
    all[z] = moments.zeroth;
    by_y[z] = moments.first;
    by_yy[z] = moments.second;
  }
  const Moments z(all), yz(by_y), yy(by_yy);
  const Packed sum(z.zeroth), y(yz.zeroth), by_z(z.first);
  return {sum.count,
          {sum.x, y.count, by_z.count},
          {sum.xx, y.x, by_z.x, Packed(yy.zeroth).count, Packed(yz.first).count,
           Packed(z.second).count}};
}

Eigen::Vector3f OccupiedCells::normal(CellKey cell) const {
  const Place at = place(cell);
  Eigen::Vector3f found = Eigen::Vector3f::Zero();
  if (at.size == 1) normals({&at.min, 1}, &found);
  return found;
}

void OccupiedCells::normals(std::span<const Eigen::Vector3i> at, Eigen::Vector3f* found) const {
  std::array<bool, kAtOnce> enough{};
  Symmetric spreads;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Sums sums = sums_around(at[i]);
    enough[i] = sums.count >= kFewest;
    const auto n = static_cast<float>(sums.count);
    const auto mean = [&](int sum) { return static_cast<float>(sum) / n; };
    const float x = mean(sums.first[0]), y = mean(sums.first[1]), z = mean(sums.first[2]);
    spreads.xx[i] = mean(sums.second[0]) - x * x;
    spreads.xy[i] = mean(sums.second[1]) - x * y;
    spreads.xz[i] = mean(sums.second[2]) - x * z;
    spreads.yy[i] = mean(sums.second[3]) - y * y;
    spreads.yz[i] = mean(sums.second[4]) - y * z;
    spreads.zz[i] = mean(sums.second[5]) - z * z;
  }
  const auto axes = thinnest_axes(spreads, enough);
  for (std::size_t i = 0; i < at.size(); ++i) {
    found[i] = enough[i] ? axes[i] : Eigen::Vector3f::Zero();
  }
}

}  // namespace voxatlas
