#include "integrate/colour_means.hpp"

#include <bit>

namespace voxatlas {
namespace {

std::span<const std::uint64_t> words_of(const Marks& hits, std::uint32_t block) {
  if (hits.has_bricks()) return hits.bits(block);
  return hits.tile(block).top;
}

std::size_t words_a_block(const Marks& hits) {
  return hits.has_bricks() ? std::tuple_size_v<BrickBits> : kBricks / 64;
}

}  // namespace

void ColourMeans::clear() {
  first_ranks_.clear();
  sums_.clear();
}

void ColourMeans::sum(const Marks& hits, std::span<const Seen> seen) {
  clear();
  const auto blocks = hits.has_bricks() ? hits.brick_slots() : hits.tile_count();
  std::uint32_t rank = 0;
  for (std::uint32_t block = 0; block < blocks; ++block) {
    for (const auto word : words_of(hits, block)) {
      first_ranks_.push_back(rank);
      rank += static_cast<std::uint32_t>(std::popcount(word));
    }
  }
  sums_.resize(rank);
  const auto words = words_a_block(hits);
  for (const auto& [place, colour] : seen) {
    const auto word = place.bit >> 6;
    const auto below =
        words_of(hits, place.block)[word] & ((std::uint64_t{1} << (place.bit & 63)) - 1);
    auto& sum = sums_[first_ranks_[place.block * words + word] +
                      static_cast<std::uint32_t>(std::popcount(below))];
    sum.r += colour.r;
    sum.g += colour.g;
    sum.b += colour.b;
    ++sum.points;
  }
}

Rgb ColourMeans::mean(std::size_t rank) const {
  const auto& sum = sums_[rank];
  const auto rounded = [&](std::uint64_t total) {
    return static_cast<std::uint8_t>((2 * total + sum.points) / (2 * sum.points));
  };
  return {rounded(sum.r), rounded(sum.g), rounded(sum.b)};
}

void ColourMeans::append(const Marks& hits, std::uint32_t tile, std::vector<Rgb>& out) const {
  const auto append_block = [&](std::uint32_t block) {
    const auto words = words_of(hits, block);
    std::size_t rank = first_ranks_[block * words.size()];
    for (const auto word : words) {
      for (int i = std::popcount(word); i > 0; --i) out.push_back(mean(rank++));
    }
  };
  if (!hits.has_bricks()) return append_block(tile);
  const auto& top = hits.tile(tile).top;
  for (std::uint32_t w = 0; w < top.size(); ++w) {
    for (auto word = top[w]; word != 0; word &= word - 1) {
      const auto brick = w << 6 | static_cast<std::uint32_t>(std::countr_zero(word));
      append_block(hits.brick_slot_of(tile, brick));
    }
  }
}

}  // namespace voxatlas
