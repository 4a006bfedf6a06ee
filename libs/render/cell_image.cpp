#include "render/cell_image.hpp"

#include <algorithm>

namespace voxatlas {

CellNumbers::CellNumbers(std::span<const PlacedCloud> clouds) : clouds_(clouds) {
  first_.reserve(clouds.size());
  for (const auto& placed : clouds) {
    first_.push_back(static_cast<std::uint32_t>(count_ + 1));
    count_ += placed.cloud->cells().size();
  }
}

CellNumbers::Found CellNumbers::find(std::uint32_t number) const {
  // The last cloud that begins at or before it; of empty ones at the same place, the last.
  const auto after = std::upper_bound(first_.begin(), first_.end(), number);
  const auto cloud = static_cast<std::size_t>(after - first_.begin()) - 1;
  return {cloud, number - first_[cloud]};
}

}  // namespace voxatlas
