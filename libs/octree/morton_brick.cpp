#include "octree/morton_brick.hpp"

#include <algorithm>
#include <cstring>

namespace voxatlas {

void Summary::add(LogOdds log_odds, std::uint64_t voxels) {
  highest_ = voxels_ == 0 ? log_odds : std::max(highest_, log_odds);
  voxels_ += voxels;
}

void Summary::add(const Colour& colour, std::uint64_t voxels) {
  if (!colour.exists()) return;
  coloured_ += voxels;
  for (std::size_t i = 0; i < 3; ++i) sum_[i] += voxels * colour.mean[i];
  count_ = std::max(count_, colour.count);
}

void Summary::add(const CellState& state, std::uint64_t voxels) {
  add(state.log_odds, voxels);
  add(state.colour, voxels);
}

void Summary::add(const Brick& brick, const BrickColours* colours) {
  for_each_bit(brick.known, [&](unsigned voxel) { add(brick.log_odds[voxel], 1); });
  if (colours == nullptr) return;
  colours->for_each([&](unsigned, const Colour& colour) { add(colour, 1); });
}

std::optional<CellState> Summary::state() const {
  if (voxels_ == 0) return std::nullopt;
  CellState result{highest_, {}};
  if (coloured_ == 0) return result;
  for (std::size_t i = 0; i < 3; ++i) {
    result.colour.mean[i] = static_cast<std::uint16_t>((2 * sum_[i] + coloured_) / (2 * coloured_));
  }
  result.colour.count = count_;
  return result;
}

MortonBrick::MortonBrick(const BrickTable& table, unsigned brick) {
  const Brick& content = table.mixed(brick);
  for (unsigned at = 0; at < kBrickVoxels; ++at) {
    log_odds_[at] = content.log_odds[kVoxelOfMorton[at]];
  }
  for (unsigned i = 0; i < known_.size(); ++i) {  // The eight voxels of a depth-6 cell.
    const unsigned lowest = kVoxelOfMorton[8 * i];
    const auto square = [&](std::uint64_t layer) {
      layer >>= lowest & 63;
      return (layer & 3) | (layer >> 6 & 12);
    };
    known_[i] = static_cast<std::uint8_t>(square(content.known[lowest >> 6]) |
                                          square(content.known[(lowest >> 6) + 1]) << 4);
  }
  const BrickColours* own = table.colours(brick);
  coloured_ = own != nullptr;
  if (!coloured_) return;
  colours_.fill({});
  own->for_each(
      [&](unsigned voxel, const Colour& colour) { colours_[kMortonOfVoxel[voxel]] = colour; });
}

CellState MortonBrick::state(unsigned at) const {
  return {log_odds_[at], coloured_ ? colours_[at] : Colour{}};
}

bool MortonBrick::is_empty(unsigned first, unsigned count) const {
  if (count == 1) return !is_known(first);
  const auto at = known_.begin() + first / 8;
  return std::all_of(at, at + count / 8, [](auto bits) { return bits == 0; });
}

std::optional<CellState> MortonBrick::uniform(unsigned first, unsigned count) const {
  if (count == 1) return is_known(first) ? std::optional(state(first)) : std::nullopt;
  const auto known = known_.begin() + first / 8;
  if (std::any_of(known, known + count / 8, [](auto bits) { return bits != 0xff; })) {
    return std::nullopt;
  }
  const auto* run = log_odds_.data() + first;
  if (std::memcmp(run, run + 1, sizeof *run * (count - 1)) != 0) return std::nullopt;
  if (coloured_) {
    const auto* colours = colours_.data() + first;
    if (!std::equal(colours, colours + count - 1, colours + 1)) return std::nullopt;
  }
  return state(first);
}

void MortonBrick::add_to(Summary& summary, unsigned first, unsigned count) const {
  for (unsigned at = first; at < first + count; ++at) {
    if (is_known(at)) summary.add(state(at));
  }
}

}  // namespace voxatlas
