#include "octree/brick_pool.hpp"

namespace voxatlas {

BrickPool::BrickPool(const BrickPool& other) : free_(other.free_), used_(other.used_) {
  slabs_.reserve(other.slabs_.size());
  for (const auto& slab : other.slabs_) slabs_.push_back(std::make_unique<Slab>(*slab));
}

BrickPool& BrickPool::operator=(const BrickPool& other) { return *this = BrickPool(other); }

std::uint16_t BrickPool::take() {
  if (!free_.empty()) {
    const std::uint16_t number = free_.back();
    free_.pop_back();
    (*this)[number] = Brick{};
    return number;
  }
  if (used_ == slabs_.size() * kSlab) slabs_.push_back(std::make_unique<Slab>());
  return static_cast<std::uint16_t>(used_++);
}

void BrickPool::give_back(std::uint16_t number) { free_.push_back(number); }

std::size_t BrickPool::memory_bytes() const {
  return slabs_.capacity() * sizeof slabs_[0] + slabs_.size() * sizeof(Slab) +
         free_.capacity() * sizeof free_[0];
}

}  // namespace voxatlas
