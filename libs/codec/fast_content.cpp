#include "codec/fast_content.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "codec/pyramid.hpp"

namespace voxatlas {
namespace {

Content content_of(const Brick& brick, unsigned voxel) {
  return has_voxel(brick.known, voxel) ? brick.log_odds[voxel] : kNothing;
}

/// How many of all voxels have the log-odds; unknown ones have 0.
unsigned count_equal(const Brick& brick, LogOdds log_odds) {
  std::uint16_t count = 0;  // As wide as what is compared, for the sake of vectors.
  for (const LogOdds each : brick.log_odds) {
    count = static_cast<std::uint16_t>(count + (each == log_odds ? 1 : 0));
  }
  return count;
}

/// The voxels that hold anything else.
VoxelMask other_than(const Brick& brick, Content content) {
  if (content == kNothing) return brick.known;
  const auto log_odds = static_cast<LogOdds>(content);
  std::array<std::uint8_t, kBrickVoxels> differs;
  for (std::size_t i = 0; i < kBrickVoxels; ++i) {
    differs[i] = brick.log_odds[i] != log_odds ? 1 : 0;
  }
  VoxelMask result;
  for (std::size_t z = 0; z < result.size(); ++z) {
    result[z] = ~brick.known[z];
    for (std::size_t y = 0; y < 8; ++y) {
      std::uint64_t row;
      std::memcpy(&row, &differs[64 * z + 8 * y], sizeof row);
      // Byte i's bit to bit 56 + i; the rest of the product lies elsewhere.
      result[z] |= row * 0x0102'0408'1020'4080ull >> 56 << 8 * y;
    }
  }
  return result;
}

/// Finds what most voxels of a brick hold; of several the one that was first so often, in Morton
/// order.
class GroundFinder {
 public:
  Content of(const Brick& brick) {
    constexpr unsigned kHalf = kBrickVoxels / 2;
    const bool all = brick.known == kAllVoxels;
    if (!all && count_of(brick.known) < kHalf) return kNothing;
    for (const unsigned guess : {0u, kBrickVoxels - 1, kHalf - 1, kHalf + 8}) {
      const LogOdds log_odds = brick.log_odds[guess];
      if (!all && log_odds == 0) continue;  // Or unknown.
      if (count_equal(brick, log_odds) > kHalf) return log_odds;
    }
    return by_counting(brick);
  }

 private:
  static std::size_t slot_of(Content content) {
    return content == kNothing ? kValues : static_cast<std::uint16_t>(content);
  }

  Content by_counting(const Brick& brick) {
    std::uint16_t most = 0;
    Content ground = kNothing;
    for (const auto voxel : kVoxelOfMorton) {
      const Content content = content_of(brick, voxel);
      if (++counts_[slot_of(content)] <= most) continue;
      ++most;
      ground = content;
    }
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      counts_[slot_of(content_of(brick, voxel))] = 0;
    }
    return ground;
  }

  static constexpr std::size_t kValues = std::size_t{1} << 16;
  std::vector<std::uint16_t> counts_ = std::vector<std::uint16_t>(kValues + 1);
};

/// Mask, exceptions and highest content of a mixed slot.
void add_exceptions(const Brick& brick, Content ground, const VoxelMask& voxels,
                    FastContent& content) {
  std::array<std::uint8_t, kMaskBytes> mask{};
  for_each_bit(voxels, [&](unsigned voxel) {
    const unsigned code = kMortonOfVoxel[voxel];
    mask[code / 8] = static_cast<std::uint8_t>(mask[code / 8] | 1u << code % 8);
  });
  content.masks.insert(content.masks.end(), mask.begin(), mask.end());
  Content highest = ground;
  for_each_exception(mask.data(), [&](unsigned code) {
    content.exceptions.push_back(content_of(brick, kVoxelOfMorton[code]));
    highest = std::max(highest, content.exceptions.back());
  });
  content.highest.push_back(highest);
}

}  // namespace

FastContent fast_content_of(const BrickTable& table) {
  using Kind = Pyramid::Kind;
  FastContent content;
  GroundFinder find_ground;
  for (unsigned i = 0; i < kBricks; ++i) {
    if (table.is_empty(i)) continue;
    auto kind = Kind::kUniform;
    if (table.is_mixed(i)) {
      const Brick& brick = table.mixed(i);
      content.ground.push_back(find_ground.of(brick));
      const VoxelMask voxels = other_than(brick, content.ground.back());
      if (any_of(voxels)) {  // Else mixed by its colours alone.
        kind = Kind::kMixed;
        add_exceptions(brick, content.ground.back(), voxels, content);
      }
    } else {
      content.ground.push_back(table.uniform_log_odds(i));
    }
    content.kinds[i] = static_cast<std::uint8_t>(kind);
  }
  return content;
}

}  // namespace voxatlas
