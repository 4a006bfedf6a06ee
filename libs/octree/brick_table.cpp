#include "octree/brick_table.hpp"

#include <algorithm>
#include <bit>

namespace voxatlas {

CellState BrickTable::uniform_state(unsigned brick) const {
  const BrickColours* own = colours(brick);
  return {uniform_log_odds(brick), own == nullptr ? Colour{} : own->at(0)};
}

const BrickColours* BrickTable::colours(unsigned brick) const {
  return bit(coloured_, brick) ? &colours_.find(brick)->second : nullptr;
}

void BrickTable::drop_brick(unsigned brick) {
  if (!is_mixed(brick)) return;
  pool_.give_back(slots_[brick]);
  set_bit(mixed_, brick, false);
}

void BrickTable::drop_colours(unsigned brick) {
  if (!bit(coloured_, brick)) return;
  colours_.erase(brick);
  set_bit(coloured_, brick, false);
}

void BrickTable::make_empty(unsigned brick) {
  drop_brick(brick);
  drop_colours(brick);
  set_bit(known_, brick, false);
  slots_[brick] = 0;
}

void BrickTable::make_uniform(unsigned brick, const CellState& state) {
  drop_brick(brick);
  set_bit(known_, brick, true);
  slots_[brick] = static_cast<std::uint16_t>(state.log_odds);
  if (state.colour.exists()) {
    colours_of(brick) = BrickColours(state.colour);
  } else {
    drop_colours(brick);
  }
}

void BrickTable::make_uniform(BrickRange range, const CellState& state) {
  const bool coloured = state.colour.exists();
  if (coloured) colours_.reserve(colours_.size() + range.count);
  if (coloured || !is_empty(range)) {
    for (unsigned i = 0; i < range.count; ++i) make_uniform(range.first + i, state);
    return;
  }
  if (range.count < 64) {
    known_[range.first / 64] |= ((std::uint64_t{1} << range.count) - 1) << range.first % 64;
  } else {
    std::fill_n(known_.begin() + range.first / 64, range.count / 64, ~std::uint64_t{0});
  }
  std::fill_n(slots_.begin() + range.first, range.count,
              static_cast<std::uint16_t>(state.log_odds));
}

void BrickTable::set_uniform_log_odds(unsigned brick, LogOdds log_odds) {
  slots_[brick] = static_cast<std::uint16_t>(log_odds);
  if (log_odds < 0) drop_colours(brick);
}

Brick& BrickTable::expand(unsigned brick) {
  if (is_mixed(brick)) return mixed(brick);
  const std::uint16_t number = pool_.take();
  Brick& fresh = pool_[number];
  if (is_uniform(brick)) {
    fresh.log_odds.fill(uniform_log_odds(brick));
    fresh.known = kAllVoxels;
  }
  slots_[brick] = number;
  set_bit(known_, brick, true);
  set_bit(mixed_, brick, true);
  return fresh;
}

BrickColours& BrickTable::colours_of(unsigned brick) {
  set_bit(coloured_, brick, true);
  return colours_[brick];
}

void BrickTable::settle(unsigned brick) {
  const BrickColours* own = colours(brick);
  if (own != nullptr && own->empty()) {
    drop_colours(brick);
    own = nullptr;
  }
  if (!is_mixed(brick)) return;
  const Brick& content = mixed(brick);
  if (!any_of(content.known)) return make_empty(brick);
  if (!voxatlas::is_uniform(content)) return;
  if (own == nullptr) return make_uniform(brick, {content.log_odds[0], {}});
  if (const auto colour = own->uniform()) make_uniform(brick, {content.log_odds[0], *colour});
}

bool BrickTable::is_empty(BrickRange range) const {
  if (range.count < 64) {
    return (known_[range.first / 64] >> range.first % 64 & ((1ull << range.count) - 1)) == 0;
  }
  const auto first = known_.begin() + range.first / 64;
  return std::all_of(first, first + range.count / 64, [](auto word) { return word == 0; });
}

bool BrickTable::is_empty() const { return is_empty(BrickRange{0, kBricks}); }

std::optional<CellState> BrickTable::uniform(BrickRange range) const {
  if (!is_uniform(range.first)) return std::nullopt;
  const CellState first = uniform_state(range.first);
  for (unsigned brick = range.first + 1; brick < range.first + range.count; ++brick) {
    if (!is_uniform(brick) || slots_[brick] != slots_[range.first]) return std::nullopt;
    if (bit(coloured_, brick) != first.colour.exists()) return std::nullopt;
    if (first.colour.exists() && uniform_state(brick).colour != first.colour) return std::nullopt;
  }
  return first;
}

void BrickTable::compact() {
  if (pool_.wasteful()) {
    BrickPool packed;
    for (unsigned brick = 0; brick < kBricks; ++brick) {
      if (!is_mixed(brick)) continue;
      const std::uint16_t number = packed.take();
      packed[number] = mixed(brick);
      slots_[brick] = number;
    }
    pool_ = std::move(packed);
  }
  if (colours_.bucket_count() > 64 + 2 * colours_.size()) colours_.rehash(0);
}

BrickTable::Plane BrickTable::maybe_occupied() const {
  Plane bricks = mixed_;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (std::uint64_t left = known_[i] & ~mixed_[i]; left != 0; left &= left - 1) {
      const auto brick =
          static_cast<unsigned>(64 * i) + static_cast<unsigned>(std::countr_zero(left));
      if (is_occupied(uniform_log_odds(brick))) bricks[i] |= left & -left;
    }
  }
  return bricks;
}

std::size_t BrickTable::memory_bytes() const {
  std::size_t bytes = sizeof *this + pool_.memory_bytes();
  bytes += colours_.bucket_count() * sizeof(void*);
  for (const auto& [brick, own] : colours_) {
    bytes += own.memory_bytes() + sizeof brick + 2 * sizeof(void*);
  }
  return bytes;
}

bool operator==(const BrickTable& a, const BrickTable& b) {
  if (a.known_ != b.known_ || a.mixed_ != b.mixed_ || a.coloured_ != b.coloured_) return false;
  for (unsigned brick = 0; brick < kBricks; ++brick) {
    const bool same =
        a.is_mixed(brick) ? a.mixed(brick) == b.mixed(brick) : a.slots_[brick] == b.slots_[brick];
    if (!same) return false;
  }
  return a.colours_ == b.colours_;
}

}  // namespace voxatlas
