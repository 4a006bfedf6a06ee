#include "codec/fast_content.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "codec/pyramid.hpp"

namespace voxatlas {
namespace {

Content content_of(const Brick& brick, unsigned voxel) {
  return has_voxel(brick.known, voxel) ? brick.log_odds[voxel] : kNothing;
}

/// What most voxels of a brick hold, and which do.
struct Ground {
  Content content;
  VoxelMask voxels;
};

VoxelMask without(const VoxelMask& a, const VoxelMask& b) {
  VoxelMask result;
  for (std::size_t z = 0; z < result.size(); ++z) result[z] = a[z] & ~b[z];
  return result;
}

unsigned first_of(const VoxelMask& mask) {
  unsigned z = 0;
  while (mask[z] == 0) ++z;
  return 64 * z + static_cast<unsigned>(std::countr_zero(mask[z]));
}

unsigned last_in_morton_order(const VoxelMask& mask) {
  unsigned last = 0;
  for_each_bit(mask,
               [&](unsigned voxel) { last = std::max(last, unsigned{kMortonOfVoxel[voxel]}); });
  return last;
}

/// Of several contents that are as common, the one that was first so often in Morton order. Looks
/// at one content after the other, as long as those left could be more than the commonest so far.
Ground ground_of(const Brick& brick) {
  Ground ground{kNothing, without(kAllVoxels, brick.known)};
  unsigned most = count_of(ground.voxels);
  VoxelMask left = brick.known;
  for (unsigned others = kBrickVoxels - most; others >= most && others > 0;) {
    const LogOdds content = brick.log_odds[first_of(left)];
    const VoxelMask voxels = both(equal_to(brick, content), left);
    const unsigned count = count_of(voxels);
    if (count > most ||
        (count == most && last_in_morton_order(voxels) < last_in_morton_order(ground.voxels))) {
      ground = {content, voxels};
      most = count;
    }
    left = without(left, voxels);
    others -= count;
  }
  return ground;
}

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
  content.exceptions.resize(content.exceptions.size() + count_of(voxels));
  Content* next = content.exceptions.data() + content.exceptions.size() - count_of(voxels);
  for_each_exception(mask.data(), [&](unsigned code) {
    *next = content_of(brick, kVoxelOfMorton[code]);
    highest = std::max(highest, *next++);
  });
  content.highest.push_back(highest);
}

}  // namespace

FastContent fast_content_of(const BrickTable& table) {
  using Kind = Pyramid::Kind;
  FastContent content;
  for (unsigned i = 0; i < kBricks; ++i) {
    if (table.is_empty(i)) continue;
    auto kind = Kind::kUniform;
    if (table.is_mixed(i)) {
      const Brick& brick = table.mixed(i);
      const Ground ground = ground_of(brick);
      content.ground.push_back(ground.content);
      const VoxelMask voxels = without(kAllVoxels, ground.voxels);
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
