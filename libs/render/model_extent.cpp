#include "render/model_extent.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace voxatlas {

Result<ModelExtent> ModelExtent::of(const Grid& grid, std::span<const TileWeight> tiles) {
  double weight = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& tile : tiles) {
    weight += static_cast<double>(tile.occupied);
    sum += static_cast<double>(tile.occupied) * middle_of(grid, tile.key);
  }
  if (weight <= 0)
    return fail(ErrorCode::kNotFound, "no view of a model where nothing is occupied");
  auto frame = EnuFrame::at(Eigen::Vector3d(sum / weight));
  if (!frame) return pass_on(frame);

  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const auto& tile : tiles) {
    const Eigen::Vector2d p = frame->to_enu(middle_of(grid, tile.key)).head<2>();
    spread += static_cast<double>(tile.occupied) / weight * p * p.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);  // Ascending.
  return ModelExtent{*frame, axes.eigenvectors().col(1),
                     std::sqrt(std::max(0.0, axes.eigenvalues()[1])),
                     std::sqrt(std::max(0.0, axes.eigenvalues()[0]))};
}

}  // namespace voxatlas
