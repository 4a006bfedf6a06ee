#include "codec/quantize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/check.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

constexpr int kLevelsOfChannel = 255;

int divide_rounded(int a, int b) { return (2 * a + b) / (2 * b); }

}  // namespace

Status Quantization::check() const {
  if (bits < 1 || bits > 16) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{} bits a log-odds, not 1..16", bits));
  }
  if (colour_bits < 0 || colour_bits > 8) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{} bits a colour channel, not 0..8", colour_bits));
  }
  if (clamp_min >= 0 || clamp_max < 0) {
    return fail(
        ErrorCode::kOutOfRange,
        fmt::format("clamps {} and {} do not stand on either side of 0", clamp_min, clamp_max));
  }
  return {};
}

LogOddsQuantizer::LogOddsQuantizer(const Quantization& how)
    : clamp_min_(how.clamp_min), clamp_max_(how.clamp_max) {
  VOX_CHECK(how.check().has_value());
  const auto step = [&](LogOdds clamp) {
    return std::abs(to_probability(clamp) - 0.5) / std::max(1, (1 << (how.bits - 1)) - 1);
  };
  free_step_ = step(how.clamp_min);
  occupied_step_ = step(how.clamp_max);
}

bool LogOddsQuantizer::within_step(LogOdds from, LogOdds to) const {
  const bool occupied = is_occupied(from);
  if (is_beyond(from) || is_occupied(to) != occupied) return from == to;
  return std::abs(to_probability(from) - to_probability(to)) <= step(occupied);
}

Colour quantize(const Colour& colour, int bits) {
  if (bits == 0 || !colour.exists()) return {};
  const int steps = (1 << bits) - 1;
  Colour result = colour;
  for (auto& mean : result.mean) {
    const int level =
        divide_rounded(std::min<int>(mean, kLevelsOfChannel << 8) * steps, kLevelsOfChannel << 8);
    mean = static_cast<std::uint16_t>(divide_rounded(level * kLevelsOfChannel, steps) << 8);
  }
  return result;
}

namespace {

std::size_t index_of(int value) { return static_cast<std::uint16_t>(value); }

/// The values that stand for a tile's: its own, the commonest first, each for all within its step
/// that nothing stands for yet. So they are what hits and misses make, which a palette codes for
/// next to nothing, and farther than a step apart, which bounds their number.
class Representatives {
 public:
  Representatives(const BrickTable& table, const LogOddsQuantizer& quantizer) {
    count(table);
    choose(quantizer);
  }

  LogOdds of(LogOdds value) const { return chosen_[index_of(value)]; }

 private:
  /// Runs, not voxels: a run costs about as much to code as a single voxel does.
  void count(const BrickTable& table) {
    for (unsigned i = 0; i < kBricks; ++i) {
      if (table.is_uniform(i)) ++counts_[index_of(table.uniform_log_odds(i))];
      if (!table.is_mixed(i)) continue;
      const Brick& brick = table.mixed(i);
      std::size_t before = kValues;
      for_each_bit(brick.known, [&](unsigned voxel) {
        const std::size_t value = index_of(brick.log_odds[voxel]);
        counts_[value] += value != before ? 1 : 0;
        before = value;
      });
    }
  }

  void choose(const LogOddsQuantizer& quantizer) {
    std::vector<LogOdds> rising;
    for (int value = INT16_MIN; value <= INT16_MAX; ++value) {
      if (counts_[index_of(value)] > 0) rising.push_back(static_cast<LogOdds>(value));
    }
    std::vector<std::size_t> order(rising.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto rank = [&](std::size_t i) {  // What cannot move stands for others first.
      const LogOdds value = rising[i];
      return std::pair(quantizer.is_beyond(value) ? 0 : 1, -counts_[index_of(value)]);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    std::vector<bool> taken(rising.size());
    for (const std::size_t i : order) {
      if (taken[i]) continue;
      const auto take = [&](std::size_t other) {
        if (other != i && !quantizer.within_step(rising[other], rising[i])) return false;
        if (!taken[other]) chosen_[index_of(rising[other])] = rising[i];
        taken[other] = true;
        return true;
      };
      for (std::size_t up = i; up < rising.size() && take(up); ++up) continue;
      for (std::size_t down = i; down-- > 0 && take(down);) continue;
    }
  }

  static constexpr std::size_t kValues = std::size_t{1} << 16;
  std::vector<std::int64_t> counts_ = std::vector<std::int64_t>(kValues);
  std::vector<LogOdds> chosen_ = std::vector<LogOdds>(kValues);
};

/// Makes a tile coarser, with the freedom that a step leaves: a voxel takes its brick's commonest
/// value where that is no farther away than the step, else what stands for it in the whole tile.
class TileQuantizer {
 public:
  TileQuantizer(const BrickTable& table, const Quantization& how)
      : quantizer_(how), representatives_(table, quantizer_), colour_bits_(how.colour_bits) {}

  void change(BrickTable& table, unsigned brick) {
    const auto* own = table.colours(brick);
    if (own != nullptr) {
      const BrickColours coarse = coarser(*own);
      table.colours_of(brick) = coarse;
    }
    if (table.is_uniform(brick)) {
      table.set_uniform_log_odds(brick, representative(table.uniform_log_odds(brick)));
    } else {
      change(table.mixed(brick));
    }
    table.settle(brick);
  }

 private:
  LogOdds representative(LogOdds value) const { return representatives_.of(value); }

  BrickColours coarser(const BrickColours& from) const {
    if (colour_bits_ == 0) return {};
    std::vector<Colour> colours;
    from.for_each([&](unsigned, const Colour& c) { colours.push_back(quantize(c, colour_bits_)); });
    return {from.voxels(), std::move(colours)};
  }

  void change(Brick& brick) {
    const LogOdds common = commonest(brick);
    for_each_bit(brick.known, [&](unsigned voxel) {
      auto& value = brick.log_odds[voxel];
      const LogOdds own = representative(value);
      value = may_join(value, common) ? common : own;
    });
  }

  /// LogOddsQuantizer::within_step, most of whose answers are plain.
  bool may_join(LogOdds value, LogOdds common) {
    if (value == common) return true;
    if (is_occupied(value) != is_occupied(common)) return false;
    if (value != asked_ || common != about_) {
      asked_ = value;
      about_ = common;
      answer_ = quantizer_.within_step(value, common);
    }
    return answer_;
  }

  LogOdds commonest(const Brick& brick) {
    LogOdds best = 0;
    std::uint16_t most = 0;
    for_each_bit(brick.known, [&](unsigned voxel) {
      const LogOdds value = representative(brick.log_odds[voxel]);
      const std::uint16_t count = ++counts_[index_of(value)];
      if (count > most || (count == most && value < best)) {
        best = value;
        most = count;
      }
    });
    for_each_bit(brick.known, [&](unsigned voxel) {
      counts_[index_of(representative(brick.log_odds[voxel]))] = 0;
    });
    return best;
  }

  LogOddsQuantizer quantizer_;
  Representatives representatives_;
  int colour_bits_;
  LogOdds asked_ = 0, about_ = 0;
  bool answer_ = true;
  std::vector<std::uint16_t> counts_ = std::vector<std::uint16_t>(1u << 16);
};

/// The voxels of a brick that are known, and those of them that are occupied.
std::pair<VoxelMask, VoxelMask> occupancy(const BrickTable& table, unsigned brick) {
  if (table.is_empty(brick)) return {};
  if (table.is_uniform(brick)) {
    return {kAllVoxels, is_occupied(table.uniform_log_odds(brick)) ? kAllVoxels : VoxelMask{}};
  }
  const Brick& mixed = table.mixed(brick);
  VoxelMask occupied = free_among(mixed, mixed.known);
  for (std::size_t i = 0; i < occupied.size(); ++i) occupied[i] ^= mixed.known[i];
  return {mixed.known, occupied};
}

}  // namespace

bool same_occupancy(const TileTree& a, const TileTree& b) {
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  for (unsigned i = 0; i < kBricks; ++i) {
    if (occupancy(*a.bricks(), i) != occupancy(*b.bricks(), i)) return false;
  }
  return true;
}

TileTree quantize(const TileTree& tree, const Quantization& how) {
  if (tree.empty()) return {};
  BrickTable table = *tree.bricks();
  TileQuantizer quantizer(table, how);
  for (unsigned i = 0; i < kBricks; ++i) {
    if (!table.is_empty(i)) quantizer.change(table, i);
  }
  return TileTree::of_bricks(std::move(table));
}

}  // namespace voxatlas
