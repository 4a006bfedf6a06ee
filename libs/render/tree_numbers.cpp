#include "render/tree_numbers.hpp"

#include <algorithm>

namespace voxatlas {

TreeNumbers::TreeNumbers(std::span<const PlacedTree> trees) : trees_(trees) {
  first_.reserve(trees.size());
  for (const auto& placed : trees) {
    first_.push_back(static_cast<std::uint32_t>(count_ + 1));
    count_ += placed.tree->node_count();
  }
}

TreeNumbers::Found TreeNumbers::find(std::uint32_t number) const {
  // The last tree that begins at or before it; of empty ones at the same place, the last.
  const auto after = std::upper_bound(first_.begin(), first_.end(), number);
  const auto tree = static_cast<std::size_t>(after - first_.begin()) - 1;
  return {tree, number - first_[tree]};
}

}  // namespace voxatlas
