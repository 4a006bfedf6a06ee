#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/solid.hpp"

namespace voxatlas {

/// Solids, found fast: a plan of square cells, each listing the solids that reach into it.
///
/// Cost:    a beam visits the cells under it and there only those whose heights it passes.
/// Threads: unchanging once made; safe to share.
class SolidGrid {
 public:
  struct Hit {
    double t = kNoHit;
    const Solid* solid = nullptr;  ///< Lives as long as the grid; nullptr: none.
  };

  explicit SolidGrid(std::vector<Solid> solids, double cell_length);

  /// The first solid that the beam enters before `limit`.
  Hit first_hit(const Beam& beam, double limit) const;

  /// The solid with the smallest signed distance, where that is below `limit`; t is that distance.
  Hit nearest(const Eigen::Vector3d& p, double limit) const;

  std::span<const Solid> solids() const { return solids_; }

 private:
  struct Cell {
    std::uint32_t begin = 0, end = 0;  ///< In entries_.
    float low = 1e30f, high = -1e30f;  ///< Heights that its solids span, rounded outwards.
  };

  struct PlanWalk;

  void size_plan();
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x);
  }
  PlanWalk start_walk(const Beam& beam, double enter) const;
  void try_cell(const Cell& cell, const Beam& beam, Hit& best) const;
  template <class Visit>
  void each_cell(const Solid& solid, Visit visit);
  int column(double x, int axis) const;

  double cell_length_;
  Eigen::Vector3d min_ = Eigen::Vector3d::Zero(), max_ = Eigen::Vector3d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<Solid> solids_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> entries_;  ///< Indices into solids_, cell by cell.
};

}  // namespace voxatlas
