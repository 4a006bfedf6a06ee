#include "codec/quantize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

constexpr int kLevelsOfChannel = 255;
/// P moves by at most a quarter of what L moves; L is rounded to the lattice.
constexpr double kHalfLattice = 0.125 / kLogOddsPerUnit;

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
  const auto side = [&](LogOdds clamp) {
    Side made{0.5, to_probability(clamp), 1 << (how.bits - 1), 0};
    const double width = std::abs(made.clamp - made.even);
    made.step = (made.levels == 1 ? width : width / (made.levels - 1)) + kHalfLattice;
    return made;
  };
  free_ = side(how.clamp_min);
  occupied_ = side(how.clamp_max);
}

LogOdds LogOddsQuantizer::nearest(LogOdds log_odds) const {
  if (is_beyond(log_odds)) return log_odds;
  const bool occupied = is_occupied(log_odds);
  const auto& [even, clamp, levels, step] = side(occupied);
  const LogOdds outermost = occupied ? clamp_max_ : clamp_min_;
  if (levels == 1) return outermost;
  const double width = clamp - even;
  const double level = std::round((to_probability(log_odds) - even) / width * (levels - 1));
  if (level >= levels - 1) return outermost;
  const double probability = even + width * level / (levels - 1);
  const double nearest = std::round(kLogOddsPerUnit * std::log(probability / (1 - probability)));
  // Free values stay below 0, where the level is 1/2 itself.
  return static_cast<LogOdds>(occupied ? nearest : std::min(nearest, -1.0));
}

bool LogOddsQuantizer::within_step(LogOdds from, LogOdds to) const {
  const bool occupied = is_occupied(from);
  if (is_beyond(from) || is_occupied(to) != occupied) return from == to;
  return std::abs(to_probability(from) - to_probability(to)) <= side(occupied).step;
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

/// A quantiser with its answers ready, and with the freedom that a step leaves: a voxel takes its
/// brick's commonest value where that is no farther away than the step.
class TileQuantizer {
 public:
  explicit TileQuantizer(const Quantization& how)
      : quantizer_(how), colour_bits_(how.colour_bits) {}

  void change(BrickTable& table, unsigned brick) {
    const auto* own = table.colours(brick);
    if (own != nullptr) {
      const BrickColours coarse = coarser(*own);
      table.colours_of(brick) = coarse;
    }
    if (table.is_uniform(brick)) {
      table.set_uniform_log_odds(brick, nearest(table.uniform_log_odds(brick)));
    } else {
      change(table.mixed(brick));
    }
    table.settle(brick);
  }

 private:
  static std::size_t index(int value) { return static_cast<std::uint16_t>(value); }

  LogOdds nearest(LogOdds value) {
    if (!known_[index(value)]) {
      known_[index(value)] = true;
      nearest_[index(value)] = quantizer_.nearest(value);
    }
    return nearest_[index(value)];
  }

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
      const LogOdds near = nearest(value);
      value = may_join(value, common) ? common : near;
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
      const LogOdds value = nearest(brick.log_odds[voxel]);
      const std::uint16_t count = ++counts_[index(value)];
      if (count > most || (count == most && value < best)) {
        best = value;
        most = count;
      }
    });
    for_each_bit(brick.known,
                 [&](unsigned voxel) { counts_[index(nearest(brick.log_odds[voxel]))] = 0; });
    return best;
  }

  LogOddsQuantizer quantizer_;
  int colour_bits_;
  LogOdds asked_ = 0, about_ = 0;
  bool answer_ = true;
  std::vector<bool> known_ = std::vector<bool>(1u << 16);
  std::vector<LogOdds> nearest_ = std::vector<LogOdds>(1u << 16);
  std::vector<std::uint16_t> counts_ = std::vector<std::uint16_t>(1u << 16);
};

}  // namespace

TileTree quantize(const TileTree& tree, const Quantization& how) {
  if (tree.empty()) return {};
  TileQuantizer quantizer(how);
  BrickTable table = *tree.bricks();
  for (unsigned i = 0; i < kBricks; ++i) {
    if (!table.is_empty(i)) quantizer.change(table, i);
  }
  return TileTree::of_bricks(std::move(table));
}

}  // namespace voxatlas
