#include "sim/solid_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace voxatlas {
namespace {

// Solids reach this far into their neighbours' cells, so that a rounding that carries a beam past a
// cell's corner carries it past no surface.
constexpr double kPad = 1e-6;

}  // namespace

/// A beam's way over the plan, cell by cell (Amanatides and Woo, in two dimensions).
struct SolidGrid::PlanWalk {
  std::array<int, 2> cell, step;
  std::array<double, 2> next, stride;  ///< t of the next border on each axis, and between borders.

  bool within(int columns, int rows) const {
    return cell[0] >= 0 && cell[0] < columns && cell[1] >= 0 && cell[1] < rows;
  }
  double leave() const { return std::min(next[0], next[1]); }
  void advance() {
    const std::size_t axis = next[0] <= next[1] ? 0 : 1;
    cell[axis] += step[axis];
    next[axis] += stride[axis];
  }
};

SolidGrid::SolidGrid(std::vector<Solid> solids, double cell_length)
    : cell_length_(cell_length), solids_(std::move(solids)) {
  if (solids_.empty()) return;
  size_plan();
  for (const Solid& solid : solids_) {
    each_cell(solid, [&](Cell& cell) {
      ++cell.end;
      cell.low = std::min(cell.low, std::nextafter(static_cast<float>(solid.min.z()), -1e30f));
      cell.high = std::max(cell.high, std::nextafter(static_cast<float>(solid.max.z()), 1e30f));
    });
  }
  std::uint32_t total = 0;
  for (Cell& cell : cells_) {
    const std::uint32_t count = cell.end;
    cell.begin = cell.end = total;
    total += count;
  }
  entries_.resize(total);
  for (std::uint32_t i = 0; i < solids_.size(); ++i) {
    each_cell(solids_[i], [&](Cell& cell) { entries_[cell.end++] = i; });
  }
}

void SolidGrid::size_plan() {
  min_ = solids_.front().min;
  max_ = solids_.front().max;
  for (const Solid& solid : solids_) {
    min_ = min_.cwiseMin(solid.min);
    max_ = max_.cwiseMax(solid.max);
  }
  min_.array() -= 2 * kPad;
  max_.array() += 2 * kPad;
  columns_ = static_cast<int>((max_.x() - min_.x()) / cell_length_) + 1;
  rows_ = static_cast<int>((max_.y() - min_.y()) / cell_length_) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
}

int SolidGrid::column(double x, int axis) const {
  const int last = (axis == 0 ? columns_ : rows_) - 1;
  const double at = std::floor((x - min_[axis]) / cell_length_);
  return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(last)));
}

template <class Visit>
void SolidGrid::each_cell(const Solid& solid, Visit visit) {
  const int x1 = column(solid.max.x() + kPad, 0), y1 = column(solid.max.y() + kPad, 1);
  for (int y = column(solid.min.y() - kPad, 1); y <= y1; ++y) {
    for (int x = column(solid.min.x() - kPad, 0); x <= x1; ++x) {
      visit(cells_[place(x, y)]);
    }
  }
}

SolidGrid::PlanWalk SolidGrid::start_walk(const Beam& beam, double enter) const {
  PlanWalk walk;
  for (int axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    walk.cell[a] = column(beam.origin[axis] + enter * beam.direction[axis], axis);
    walk.step[a] = beam.direction[axis] > 0 ? 1 : -1;
    walk.stride[a] = cell_length_ * std::abs(beam.inverse[axis]);
    const double border = min_[axis] + cell_length_ * (walk.cell[a] + (walk.step[a] > 0 ? 1 : 0));
    walk.next[a] = (border - beam.origin[axis]) * beam.inverse[axis];
  }
  return walk;
}

void SolidGrid::try_cell(const Cell& cell, const Beam& beam, Hit& best) const {
  for (std::uint32_t i = cell.begin; i < cell.end; ++i) {
    const Solid& solid = solids_[entries_[i]];
    const double t = entry(solid, beam);
    if (t < best.t) best = {t, &solid};
  }
}

SolidGrid::Hit SolidGrid::first_hit(const Beam& beam, double limit) const {
  Hit best{limit, nullptr};
  if (solids_.empty()) return {};
  double enter = 0, leave = limit;
  for (int axis = 0; axis < 3; ++axis) {
    const double t0 = (min_[axis] - beam.origin[axis]) * beam.inverse[axis];
    const double t1 = (max_[axis] - beam.origin[axis]) * beam.inverse[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  if (enter > leave) return {};

  PlanWalk walk = start_walk(beam, enter);
  while (enter <= leave && enter < best.t && walk.within(columns_, rows_)) {
    const Cell& cell = cells_[place(walk.cell[0], walk.cell[1])];
    const double exit = std::min(walk.leave(), leave);
    const double z0 = beam.origin.z() + enter * beam.direction.z();
    const double z1 = beam.origin.z() + exit * beam.direction.z();
    if (std::max(z0, z1) >= cell.low && std::min(z0, z1) <= cell.high) try_cell(cell, beam, best);
    enter = walk.leave();
    walk.advance();
  }
  return best.solid != nullptr ? best : Hit{};
}

SolidGrid::Hit SolidGrid::nearest(const Eigen::Vector3d& p, double limit) const {
  Hit best{limit, nullptr};
  if (solids_.empty() || ((p - min_).array() < -limit).any() ||
      ((p - max_).array() > limit).any()) {
    return {};
  }
  const int x1 = column(p.x() + limit, 0), y1 = column(p.y() + limit, 1);
  for (int y = column(p.y() - limit, 1); y <= y1; ++y) {
    for (int x = column(p.x() - limit, 0); x <= x1; ++x) {
      const Cell& cell = cells_[place(x, y)];
      for (std::uint32_t i = cell.begin; i < cell.end; ++i) {
        const double distance = signed_distance(solids_[entries_[i]], p);
        if (distance < best.t) best = {distance, &solids_[entries_[i]]};
      }
    }
  }
  return best.solid != nullptr ? best : Hit{};
}

}  // namespace voxatlas
