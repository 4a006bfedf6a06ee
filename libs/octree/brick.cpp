#include "octree/brick.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/brick.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace voxatlas {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<LogOdds, 16>;
constexpr std::size_t kLanes = hn::MaxLanes(Lanes());
alignas(32) constexpr LogOdds kLaneBit[16] = {1,   2,   4,    8,    16,   32,   64,    128,
                                              256, 512, 1024, 2048, 4096, 8192, 16384, INT16_MIN};

/// The lanes whose bits are set.
HWY_ATTR hn::Mask<Lanes> lanes_of(std::uint64_t bits) {
  const auto bit = hn::Load(Lanes(), kLaneBit);
  return hn::Eq(hn::And(hn::Set(Lanes(), static_cast<LogOdds>(bits)), bit), bit);
}

/// A sum is clamped on the side it moves to before the addition, so that it stays inside int16, and
/// on the other side after it. Words without a bit are skipped, but nothing smaller is: what is set
/// within a word is not to be guessed.
HWY_ATTR void miss_word(LogOdds* log_odds, std::uint64_t word, const SensorModel& model) {
  const Lanes d;
  const auto least = hn::Set(d, static_cast<LogOdds>(model.clamp_min - model.miss));
  const auto addend = hn::Set(d, model.miss), most = hn::Set(d, model.clamp_max);
  for (std::size_t i = 0; i < 64; i += kLanes) {
    const auto before = hn::Load(d, log_odds + i);
    const auto after = hn::Min(hn::Add(hn::Max(before, least), addend), most);
    hn::Store(hn::IfThenElse(lanes_of(word >> i), after, before), d, log_odds + i);
  }
}

HWY_ATTR void hit_word(LogOdds* log_odds, std::uint64_t word, const SensorModel& model) {
  const Lanes d;
  const auto most = hn::Set(d, static_cast<LogOdds>(model.clamp_max - model.hit));
  const auto addend = hn::Set(d, model.hit), least = hn::Set(d, model.clamp_min);
  for (std::size_t i = 0; i < 64; i += kLanes) {
    const auto before = hn::Load(d, log_odds + i);
    const auto after = hn::Max(hn::Add(hn::Min(before, most), addend), least);
    hn::Store(hn::IfThenElse(lanes_of(word >> i), after, before), d, log_odds + i);
  }
}

HWY_ATTR void update_brick(Brick& brick, const VoxelMask& misses, const VoxelMask& hits,
                           const SensorModel& model) {
  for (std::size_t z = 0; z < 8; ++z) {
    LogOdds* log_odds = brick.log_odds.data() + 64 * z;
    if (misses[z] != 0) miss_word(log_odds, misses[z], model);
    if (hits[z] != 0) hit_word(log_odds, hits[z], model);
    brick.known[z] |= misses[z] | hits[z];
  }
}

/// The lanes of a layer that are set, as a word of a mask.
template <class Test>
HWY_ATTR std::uint64_t word_of(const LogOdds* layer, const Test& test) {
  const Lanes d;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < 64; i += kLanes) {
    std::array<std::uint8_t, 8> bits{};  // Of at most 16 lanes; Highway may write a whole word.
    hn::StoreMaskBits(d, test(hn::Load(d, layer + i)), bits.data());
    word |= (bits[0] | std::uint64_t{bits[1]} << 8) << i;
  }
  return word;
}

HWY_ATTR VoxelMask equal_voxels(const Brick& brick, LogOdds log_odds) {
  const auto wanted = hn::Set(Lanes(), log_odds);
  VoxelMask result;
  for (std::size_t z = 0; z < 8; ++z) {
    result[z] = word_of(brick.log_odds.data() + 64 * z,
                        [&](auto lanes) HWY_ATTR { return hn::Eq(lanes, wanted); });
  }
  return result;
}

HWY_ATTR VoxelMask free_voxels(const Brick& brick, const VoxelMask& voxels) {
  VoxelMask result{};
  for (std::size_t z = 0; z < 8; ++z) {
    if (voxels[z] == 0) continue;
    result[z] = voxels[z] & word_of(brick.log_odds.data() + 64 * z, [](auto lanes) HWY_ATTR {
                  return hn::Lt(lanes, hn::Zero(Lanes()));
                });
  }
  return result;
}

}  // namespace HWY_NAMESPACE
}  // namespace voxatlas
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace voxatlas {
namespace {

constexpr std::size_t kRow = 8;
constexpr std::array<LogOdds, kRow> kRowBit{1, 2, 4, 8, 16, 32, 64, 128};

void write(Brick& brick, const VoxelMask& voxels, LogOdds log_odds) {
  for (std::size_t z = 0; z < 8; ++z) {
    std::uint64_t word = voxels[z];
    LogOdds* row = brick.log_odds.data() + 64 * z;
    for (; word != 0; word >>= 8, row += kRow) {
      const LogOdds bits = static_cast<LogOdds>(word & 0xff);
      for (std::size_t x = 0; x < kRow; ++x) {
        row[x] = (bits & kRowBit[x]) == kRowBit[x] ? log_odds : row[x];
      }
    }
  }
}

}  // namespace

HWY_EXPORT(update_brick);

void update(Brick& brick, const VoxelMask& misses, const VoxelMask& hits,
            const SensorModel& model) {
  HWY_DYNAMIC_DISPATCH(update_brick)(brick, misses, hits, model);
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

HWY_EXPORT(equal_voxels);

VoxelMask equal_to(const Brick& brick, LogOdds log_odds) {
  return HWY_DYNAMIC_DISPATCH(equal_voxels)(brick, log_odds);
}

HWY_EXPORT(free_voxels);

VoxelMask free_among(const Brick& brick, const VoxelMask& voxels) {
  return HWY_DYNAMIC_DISPATCH(free_voxels)(brick, voxels);
}

}  // namespace voxatlas
#endif
