// The delta's wire format, as FORMAT.md states it.
#include <fmt/format.h>

#include <bit>

#include "base/check.hpp"
#include "octree/mask_bytes.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {
namespace {

constexpr std::uint8_t kVersion = 1;

enum ColourKind : std::uint8_t { kNoHit = 0, kEveryHit = 1, kSomeHits = 2 };

using BrickPlane = std::array<std::uint64_t, kBricks / 64>;

void put_coarse(const CellSet& set, ByteWriter& out) {
  const auto word = [&](std::size_t i) { return set.coarse.empty() ? 0 : set.coarse[i]; };
  if (set.depth <= 1) return out.put(static_cast<std::uint8_t>(word(0)));
  if (set.depth == 2) return put_word(word(0), out);
  BrickPlane plane{};
  std::copy(set.coarse.begin(), set.coarse.end(), plane.begin());
  if (set.depth == 3) return put_block(std::span(plane).first<8>(), out);
  put_plane(plane, out);
}

void put_bricks(const CellSet& set, ByteWriter& out) {
  BrickPlane present{};
  for (const auto& mask : set.bricks) {
    present[mask.brick / 64] |= std::uint64_t{1} << mask.brick % 64;
  }
  put_plane(present, out);
  for (const auto& mask : set.bricks) {
    if (set.depth == kDepth) {
      put_block(mask.bits, out);
    } else if (const auto cells = cells_of_voxels(mask.bits, set.depth); set.depth == 6) {
      put_word(cells, out);
    } else {
      out.put(static_cast<std::uint8_t>(cells));
    }
  }
}

void put_set(const CellSet& set, ByteWriter& out) {
  VOX_CHECK(set.depth >= 0 && set.depth <= kDepth);
  out.put(static_cast<std::uint8_t>(set.depth));
  set.depth <= kBrickDepth ? put_coarse(set, out) : put_bricks(set, out);
}

/// One bit for each hit, in the order of the hits: has it a colour?
Bytes coloured_bits(const TileDelta& delta, std::uint64_t hits) {
  Bytes bits((hits + 7) / 8);
  std::size_t i = 0;
  delta.hits.for_each([&](CellKey cell) {
    if (delta.coloured.contains(cell)) bits[i / 8] |= static_cast<std::uint8_t>(1u << i % 8);
    ++i;
  });
  return bits;
}

void put_colours(const TileDelta& delta, ByteWriter& out) {
  const std::uint64_t hits = delta.hits.size(), coloured = delta.coloured.size();
  VOX_CHECK(delta.colours.size() == coloured && coloured <= hits);
  if (coloured == 0) return out.put(std::uint8_t{kNoHit});
  VOX_CHECK(delta.coloured.depth == delta.hits.depth);
  out.put(std::uint8_t{coloured == hits ? kEveryHit : kSomeHits});
  if (coloured != hits) out.put_bytes(coloured_bits(delta, hits));
  static_assert(sizeof(Rgb) == 3);
  out.put_bytes({reinterpret_cast<const std::uint8_t*>(delta.colours.data()), 3 * coloured});
}

bool get_coarse(ByteReader& in, CellSet& set) {
  BrickPlane plane{};
  bool ok = true;
  std::size_t words = 1;
  if (set.depth <= 1) {
    plane[0] = in.get<std::uint8_t>();
    ok = in.ok() && (set.depth == 1 || plane[0] <= 1);
  } else if (set.depth == 2) {
    ok = get_word(in, plane[0]);
  } else if (set.depth == 3) {
    ok = get_block(in, std::span(plane).first<8>());
    words = 8;
  } else {
    ok = get_plane(in, plane);
    words = plane.size();
  }
  if (plane != BrickPlane{}) {
    set.coarse.assign(plane.begin(), plane.begin() + static_cast<std::ptrdiff_t>(words));
  }
  return ok;
}

bool get_brick(ByteReader& in, int depth, VoxelMask& voxels) {
  if (depth == kDepth) return get_block(in, voxels) && any_of(voxels);
  std::uint64_t cells = 0;
  if (depth == 5) {
    cells = in.get<std::uint8_t>();
  } else if (!get_word(in, cells)) {
    return false;
  }
  voxels = voxels_of_cells(cells, depth);
  return cells != 0;
}

bool get_bricks(ByteReader& in, CellSet& set) {
  BrickPlane present{};
  if (!get_plane(in, present)) return false;
  std::size_t count = 0;
  for (const auto word : present) count += static_cast<std::size_t>(std::popcount(word));
  if (count > in.remaining()) return false;  // A brick takes a byte at least.
  set.bricks.reserve(count);
  for (std::size_t i = 0; i < present.size(); ++i) {
    for (std::uint64_t word = present[i]; word != 0; word &= word - 1) {
      const auto brick = 64 * i + static_cast<std::size_t>(std::countr_zero(word));
      set.bricks.push_back({static_cast<std::uint16_t>(brick), {}});
      if (!get_brick(in, set.depth, set.bricks.back().bits)) return false;
    }
  }
  return true;
}

bool get_set(ByteReader& in, CellSet& set) {
  set.depth = in.get<std::uint8_t>();
  if (!in.ok() || set.depth > kDepth) return false;
  return set.depth <= kBrickDepth ? get_coarse(in, set) : get_bricks(in, set);
}

/// The part of `hits` whose bits are set. False where bits beyond the hits are.
bool get_coloured(ByteView bits, std::uint64_t hits, TileDelta& delta) {
  std::size_t i = 0;
  delta.hits.for_each([&](CellKey cell) {
    if (bits[i / 8] >> i % 8 & 1) delta.coloured.insert(cell);
    ++i;
  });
  const auto coloured = delta.coloured.size();
  return coloured > 0 && coloured < hits && (hits % 8 == 0 || bits.back() >> hits % 8 == 0);
}

bool get_colours(ByteReader& in, TileDelta& delta) {
  const std::uint64_t hits = delta.hits.size();
  const auto kind = in.get<std::uint8_t>();
  delta.coloured.depth = delta.hits.depth;
  if (kind == kNoHit) return in.ok();
  if (kind > kSomeHits || hits == 0) return false;
  std::uint64_t coloured = hits;
  if (kind == kSomeHits) {
    const ByteView bits = in.get_bytes((hits + 7) / 8);
    if (!in.ok() || !get_coloured(bits, hits, delta)) return false;
    coloured = delta.coloured.size();
  } else {
    delta.coloured = delta.hits;
  }
  const ByteView rgb = in.get_bytes(3 * coloured);
  if (!in.ok()) return false;
  delta.colours.resize(rgb.size() / 3);
  for (std::size_t i = 0; i < delta.colours.size(); ++i) {
    delta.colours[i] = {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]};
  }
  return true;
}

tl::unexpected<Error> corrupt(const char* what, const ByteReader& in, ByteView bytes) {
  return fail(ErrorCode::kCorrupt, fmt::format("tile delta: bad {} at byte {} of {}", what,
                                               in.position(), bytes.size()));
}

}  // namespace

void encode_delta(const TileDelta& delta, Bytes& out) {
  ByteWriter writer(out);
  writer.put(kVersion);
  put_set(delta.misses, writer);
  put_set(delta.hits, writer);
  put_colours(delta, writer);
}

Result<TileDelta> decode_delta(ByteView bytes) {
  ByteReader in(bytes);
  TileDelta delta;
  if (in.get<std::uint8_t>() != kVersion) return corrupt("version", in, bytes);
  if (!get_set(in, delta.misses)) return corrupt("misses", in, bytes);
  if (!get_set(in, delta.hits)) return corrupt("hits", in, bytes);
  if (!get_colours(in, delta)) return corrupt("colours", in, bytes);
  if (!in.at_end()) return corrupt("end", in, bytes);
  if (!delta.valid()) return corrupt("delta: a cell is both missed and hit", in, bytes);
  return delta;
}

}  // namespace voxatlas
