#include "octree/brick.hpp"

#include <algorithm>
#include <cstring>

namespace voxatlas {
namespace {

constexpr std::size_t kRow = 8;

using Lanes = std::array<LogOdds, kRow>;
constexpr Lanes kLaneBit{1, 2, 4, 8, 16, 32, 64, 128};

/// An addend and the bounds that keep the sum inside int16 and inside the clamps: a sum is clamped
/// on the side it moves to before the addition, on the other side after it.
struct Step {
  LogOdds addend, before_min, before_max, after_min, after_max;
};

Step hit_step(const SensorModel& model) {
  return {model.hit, INT16_MIN, static_cast<LogOdds>(model.clamp_max - model.hit), model.clamp_min,
          INT16_MAX};
}

Step miss_step(const SensorModel& model) {
  return {model.miss, static_cast<LogOdds>(model.clamp_min - model.miss), INT16_MAX, INT16_MIN,
          model.clamp_max};
}

/// One row of eight voxels, without a branch in it: the compiler turns each line into one vector
/// operation.
inline void add_to_row(LogOdds* row, unsigned bits, const Step& step) {
  for (std::size_t x = 0; x < kRow; ++x) {
    const LogOdds before = std::max(std::min(row[x], step.before_max), step.before_min);
    const LogOdds sum = static_cast<LogOdds>(before + step.addend);
    const LogOdds after = std::max(std::min(sum, step.after_max), step.after_min);
    const bool chosen = (static_cast<LogOdds>(bits) & kLaneBit[x]) == kLaneBit[x];
    row[x] = chosen ? after : row[x];
  }
}

void add(Brick& brick, const VoxelMask& voxels, const Step& step) {
  for (std::size_t z = 0; z < 8; ++z) {
    std::uint64_t word = voxels[z];
    LogOdds* row = brick.log_odds.data() + 64 * z;
    for (; word != 0; word >>= 8, row += kRow) {
      if (const unsigned bits = word & 0xff; bits != 0) add_to_row(row, bits, step);
    }
    brick.known[z] |= voxels[z];
  }
}

void write(Brick& brick, const VoxelMask& voxels, LogOdds log_odds) {
  for (std::size_t z = 0; z < 8; ++z) {
    std::uint64_t word = voxels[z];
    LogOdds* row = brick.log_odds.data() + 64 * z;
    for (; word != 0; word >>= 8, row += kRow) {
      const LogOdds bits = static_cast<LogOdds>(word & 0xff);
      for (std::size_t x = 0; x < kRow; ++x) {
        row[x] = (bits & kLaneBit[x]) == kLaneBit[x] ? log_odds : row[x];
      }
    }
  }
}

}  // namespace

void update(Brick& brick, const VoxelMask& misses, const VoxelMask& hits,
            const SensorModel& model) {
  add(brick, misses, miss_step(model));
  add(brick, hits, hit_step(model));
}

void assign(Brick& brick, const VoxelMask& voxels, LogOdds log_odds) {
  write(brick, voxels, log_odds);
  for (std::size_t z = 0; z < 8; ++z) brick.known[z] |= voxels[z];
}

void forget(Brick& brick, const VoxelMask& voxels) {
  write(brick, voxels, 0);
  for (std::size_t z = 0; z < 8; ++z) brick.known[z] &= ~voxels[z];
}

bool is_uniform(const Brick& brick) {
  if (brick.known != kAllVoxels) return false;
  // All equal: shifted by one they are the same bytes.
  return std::memcmp(brick.log_odds.data(), brick.log_odds.data() + 1,
                     sizeof(LogOdds) * (kBrickVoxels - 1)) == 0;
}

VoxelMask free_among(const Brick& brick, const VoxelMask& voxels) {
  VoxelMask result{};
  for_each_bit(voxels, [&](unsigned voxel) {
    if (brick.log_odds[voxel] < 0) result[voxel >> 6] |= std::uint64_t{1} << (voxel & 63);
  });
  return result;
}

}  // namespace voxatlas
