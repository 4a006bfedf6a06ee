#include "render/occupied_cells.hpp"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

/// Cells as a plain array, and the fit around one of them in double, cell by cell.
class Oracle {
 public:
  explicit Oracle(int edge) : edge_(edge), set_(std::size_t(edge * edge * edge)) {}

  void insert(int x, int y, int z) { set_[at(x, y, z)] = true; }
  bool holds(int x, int y, int z) const {
    const auto inside = [this](int i) { return i >= 0 && i < edge_; };
    return inside(x) && inside(y) && inside(z) && set_[at(x, y, z)];
  }

  struct Fit {
    int count = 0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double gap = 0;  ///< Between the smallest eigenvalue and the next: 0 is no plane.
  };
  Fit fit(int x, int y, int z) const {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 125; ++i) {
      const int dx = i % 5 - 2, dy = i / 5 % 5 - 2, dz = i / 25 - 2;
      if (holds(x + dx, y + dy, z + dz)) points.emplace_back(dx, dy, dz);
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : points) mean += p / double(points.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const auto& p : points) spread += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread / double(points.size()));
    return {int(points.size()), axes.eigenvectors().col(0),
            axes.eigenvalues()[1] - axes.eigenvalues()[0]};
  }

 private:
  std::size_t at(int x, int y, int z) const { return std::size_t((z * edge_ + y) * edge_ + x); }
  int edge_;
  std::vector<bool> set_;
};

CellKey cell_at(int x, int y, int z, int depth) {
  const int shift = kDepth - depth;
  return CellKey::of_voxel(
      {std::uint32_t(x) << shift, std::uint32_t(y) << shift, std::uint32_t(z) << shift}, depth);
}

TEST_CASE("a cell's normal is that of the best plane through its neighbours",
          "[occupied][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  std::normal_distribution<double> normal;
  int compared = 0, without = 0;
  for (const int depth : {3, 4, 5}) {
    const int edge = 1 << depth;
    for (int round = 0; round < 20; ++round) {
      OccupiedCells cells(depth);
      Oracle oracle(edge);
      const Eigen::Vector3d up(normal(rng), normal(rng), normal(rng));
      for (int i = 0; i < edge * edge * edge; ++i) {
        const Eigen::Vector3i p(i % edge, i / edge % edge, i / edge / edge);
        const double off = up.normalized().dot(p.cast<double>()) - edge / 3.0;
        if (std::abs(off) > 0.6 && rng() % 200 != 0) continue;  // A plane, and stray cells.
        oracle.insert(p.x(), p.y(), p.z());
        cells.insert(cell_at(p.x(), p.y(), p.z(), depth));
      }
      for (int i = 0; i < edge * edge * edge; ++i) {
        const int x = i % edge, y = i / edge % edge, z = i / edge / edge;
        if (!oracle.holds(x, y, z)) continue;
        const auto expected = oracle.fit(x, y, z);
        const Eigen::Vector3d found = cells.normal(cell_at(x, y, z, depth)).cast<double>();
        if (expected.count < OccupiedCells::kFewest) {
          REQUIRE(found.isZero());
          ++without;
          continue;
        }
        REQUIRE(found.norm() == Approx(1).margin(1e-4));
        if (expected.gap < 0.1) continue;
        CAPTURE(depth, x, y, z);
        REQUIRE(std::abs(found.dot(expected.normal)) > 0.999);
        ++compared;
      }
    }
  }
  REQUIRE(compared > 1000);
  REQUIRE(without > 10);
}

TEST_CASE("a coarser leaf has no normal, but counts for its neighbours", "[occupied]") {
  OccupiedCells cells(kDepth);
  const CellKey coarse{5, 0};
  cells.insert(coarse);  // Voxels 0..3 on each axis.
  REQUIRE(cells.normal(coarse).isZero());
  const CellKey beside = CellKey::of_voxel({4, 1, 1}, kDepth);
  cells.insert(beside);
  REQUIRE_FALSE(cells.normal(beside).isZero());
  REQUIRE_FALSE(cells.surround(beside));
}

}  // namespace
}  // namespace voxatlas
