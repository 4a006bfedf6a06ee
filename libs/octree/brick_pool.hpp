#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "octree/brick.hpp"

namespace voxatlas {

/// Bricks by number, in slabs: a brick keeps its address while others come and go.
class BrickPool {
 public:
  BrickPool() = default;
  BrickPool(const BrickPool& other);
  BrickPool& operator=(const BrickPool& other);
  BrickPool(BrickPool&&) noexcept = default;
  BrickPool& operator=(BrickPool&&) noexcept = default;

  std::uint16_t take();  ///< The number of an all-unknown brick.
  void give_back(std::uint16_t number);

  Brick& operator[](std::uint16_t number) { return (*slabs_[number / kSlab])[number % kSlab]; }
  const Brick& operator[](std::uint16_t number) const {
    return (*slabs_[number / kSlab])[number % kSlab];
  }

  /// More than a slab and an eighth of all stand unused: worth a copy of what is used.
  bool wasteful() const {
    const std::size_t all = slabs_.size() * kSlab;
    return all - used_ + free_.size() > kSlab + all / 8;
  }
  std::size_t memory_bytes() const;

 private:
  static constexpr std::size_t kSlab = 15;  // 16 320 bytes: allocators hand out 16 KiB for them.
  using Slab = std::array<Brick, kSlab>;

  std::vector<std::unique_ptr<Slab>> slabs_;
  std::vector<std::uint16_t> free_;
  std::size_t used_ = 0;  ///< Numbers ever given out, those in free_ among them.
};

}  // namespace voxatlas
