#include "integrate/fold.hpp"

#include <algorithm>
#include <bit>

#include "integrate/each_bit.hpp"
#include "octree/brick_mask.hpp"

namespace voxatlas {
namespace {

/// ORs neighbours within groups of `edge` bits that lie `stride` apart, then fills each group.
std::uint64_t widen_axis(std::uint64_t word, int edge, int stride, std::uint64_t lowest) {
  for (int reach = edge / 2; reach > 0; reach /= 2) word |= word >> reach * stride;
  word &= lowest;
  for (int reach = 1; reach < edge; reach *= 2) word |= word << reach * stride;
  return word;
}

/// Clears [first, first + count), where count is a power of 8 and first a multiple of it.
void clear_range(TopBits& top, std::uint32_t first, std::uint32_t count) {
  if (count >= 64) {
    std::fill_n(top.begin() + (first >> 6), count >> 6, 0);
  } else {
    top[first >> 6] &= ~(((std::uint64_t{1} << count) - 1) << (first & 63));
  }
}

/// Drops from cells of depth `depth` those related to a cell of `hits`, of depth `hit_depth`; both
/// 0..4, bricks counting as cells of depth 4.
void drop_related(TopBits& top, int depth, const TopBits& hits, int hit_depth) {
  if (depth == hit_depth) {
    for (std::size_t w = 0; w < top.size(); ++w) top[w] &= ~hits[w];
    return;
  }
  for_each_top(hits, [&](std::uint32_t hit) {
    if (depth < hit_depth) {
      clear_range(top, hit >> 3 * (hit_depth - depth), 1);
    } else {
      const int below = 3 * (depth - hit_depth);
      clear_range(top, hit << below, 1u << below);
    }
  });
}

/// Both depths 5..7: the same within each brick that has both.
void drop_related_in_bricks(Marks& misses, std::uint32_t miss_tile, const Marks& hits,
                            std::uint32_t hit_tile) {
  auto& miss_top = misses.tile(miss_tile).top;
  const auto& hit_top = hits.tile(hit_tile).top;
  const int coarser = std::min(misses.depth(), hits.depth());
  TopBits both;
  for (std::size_t w = 0; w < both.size(); ++w) both[w] = miss_top[w] & hit_top[w];
  for_each_top(both, [&](std::uint32_t brick) {
    auto& bits = misses.bits(misses.brick_slot_of(miss_tile, brick));
    auto taken = hits.bits(hits.brick_slot_of(hit_tile, brick));
    widen(bits, misses.depth());
    widen(taken, coarser);
    std::uint64_t left = 0;
    for (std::size_t z = 0; z < bits.size(); ++z) left |= bits[z] &= ~taken[z];
    if (left == 0) clear_range(miss_top, brick, 1);
  });
}

CellSet to_cells(const Marks& marks, std::uint32_t tile, std::uint64_t& count) {
  const auto& top = marks.tile(tile).top;
  CellSet cells;
  cells.depth = marks.depth();
  std::uint64_t tops = 0;
  for (const auto word : top) tops += static_cast<std::uint64_t>(std::popcount(word));
  if (tops == 0) return cells;
  if (!marks.has_bricks()) {
    const auto words = ((std::size_t{1} << 3 * marks.depth()) + 63) / 64;
    cells.coarse.assign(top.begin(), top.begin() + static_cast<std::ptrdiff_t>(words));
    count += tops;
    return cells;
  }
  cells.bricks.reserve(tops);
  std::uint64_t voxels = 0;
  for_each_top(top, [&](std::uint32_t brick) {
    auto bits = marks.bits(marks.brick_slot_of(tile, brick));
    widen(bits, marks.depth());
    voxels += count_of(bits);
    cells.bricks.push_back({static_cast<std::uint16_t>(brick), bits});
  });
  count += voxels >> 3 * (kDepth - marks.depth());
  return cells;
}

/// A tile of the scan, and its slots among the marks.
struct Touched {
  TileKey key;
  std::uint32_t miss = Marks::kNone, hit = Marks::kNone;
};

/// The tiles of both, ascending by key, each once.
std::vector<Touched> touched_tiles(const Marks& misses, const Marks& hits) {
  std::vector<Touched> touched;
  touched.reserve(misses.tile_count() + hits.tile_count());
  const auto key = [](const Marks& marks, std::uint32_t slot) {
    return *TileKey::from_index(marks.tile(slot).index);  // Made of cells of the grid: valid.
  };
  for (std::uint32_t i = 0; i < misses.tile_count(); ++i) {
    touched.push_back({key(misses, i), i, Marks::kNone});
  }
  for (std::uint32_t i = 0; i < hits.tile_count(); ++i) {
    touched.push_back({key(hits, i), Marks::kNone, i});
  }
  std::sort(touched.begin(), touched.end(), [](const Touched& a, const Touched& b) {
    return a.key != b.key ? a.key < b.key : a.hit < b.hit;
  });
  std::size_t kept = 0;
  for (const auto& tile : touched) {
    if (kept > 0 && touched[kept - 1].key == tile.key) {
      auto& other = touched[kept - 1];
      other.miss = std::min(other.miss, tile.miss);
      other.hit = std::min(other.hit, tile.hit);
    } else {
      touched[kept++] = tile;
    }
  }
  touched.erase(touched.begin() + static_cast<std::ptrdiff_t>(kept), touched.end());
  return touched;
}

void drop_related_misses(Marks& misses, const Marks& hits, const Touched& tile) {
  if (misses.has_bricks() && hits.has_bricks()) {
    drop_related_in_bricks(misses, tile.miss, hits, tile.hit);
  } else {
    drop_related(misses.tile(tile.miss).top, std::min(misses.depth(), kBrickDepth),
                 hits.tile(tile.hit).top, std::min(hits.depth(), kBrickDepth));
  }
}

}  // namespace

void widen(BrickBits& bits, int depth) {
  if (depth >= kDepth) return;
  const int edge = 1 << (kDepth - depth);
  const std::uint64_t lowest_x = edge == 2 ? 0x5555555555555555u : 0x1111111111111111u;
  const std::uint64_t lowest_y = edge == 2 ? 0x00ff00ff00ff00ffu : 0x000000ff000000ffu;
  for (std::size_t z = 0; z < bits.size(); z += static_cast<std::size_t>(edge)) {
    std::uint64_t all = 0;
    for (int i = 0; i < edge; ++i) all |= bits[z + static_cast<std::size_t>(i)];
    all = widen_axis(all, edge, 1, lowest_x);
    all = widen_axis(all, edge, 8, lowest_y);
    std::fill_n(bits.begin() + static_cast<std::ptrdiff_t>(z), edge, all);
  }
}

ScanDelta fold(Marks& misses, const Marks& hits, const ColourMeans& colours) {
  ScanDelta scan;
  const auto touched = touched_tiles(misses, hits);
  scan.tiles.reserve(touched.size());
  for (const auto& tile : touched) {
    TileDelta delta;
    delta.misses.depth = misses.depth();
    delta.hits.depth = delta.coloured.depth = hits.depth();
    if (tile.miss != Marks::kNone) {
      if (tile.hit != Marks::kNone) drop_related_misses(misses, hits, tile);
      delta.misses = to_cells(misses, tile.miss, scan.counts.cells_missed);
    }
    if (tile.hit != Marks::kNone) {
      delta.hits = to_cells(hits, tile.hit, scan.counts.cells_hit);
      if (colours.any()) {
        delta.coloured = delta.hits;
        colours.append(hits, tile.hit, delta.colours);
      }
    }
    if (!delta.empty()) scan.tiles.emplace_back(tile.key, std::move(delta));
  }
  return scan;
}

}  // namespace voxatlas
