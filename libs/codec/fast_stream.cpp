#include "codec/fast_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/check.hpp"
#include "codec/fast_content.hpp"
#include "codec/fast_places.hpp"
#include "octree/brick_table.hpp"

namespace voxatlas {
namespace {

using Kind = Pyramid::Kind;

tl::unexpected<Error> corrupt(const char* what, std::size_t value) {
  return fail(ErrorCode::kCorrupt, fmt::format("tile: {} {}", what, value));
}

void put_colour(const Colour& colour, ByteWriter& out) {
  out.put(static_cast<std::uint8_t>(colour.count));
  for (const auto mean : colour.mean) out.put(mean);
}

bool get_colour(ByteReader& in, Colour& colour) {
  colour.count = in.get<std::uint8_t>();
  for (auto& mean : colour.mean) mean = in.get<std::uint16_t>();
  return in.ok() && colour.exists() && colour.count <= Colour::kMaxCount;
}

/// The palette of a tile, and the place of each content.
class Palette {
 public:
  explicit Palette(const FastContent& tile) {
    for (const auto content : tile.ground) mark(content);
    for (const auto content : tile.exceptions) mark(content);
    std::sort(values.begin(), values.end());
    for (std::size_t i = 0; i < values.size(); ++i) {
      places_[index_of(values[i])] = static_cast<Place>(i + 1);
    }
  }

  std::vector<Place> places_of(const std::vector<Content>& contents) const {
    std::vector<Place> places(contents.size());
    std::transform(contents.begin(), contents.end(), places.begin(), [&](Content content) {
      return content == kNothing ? kUnknown : places_[index_of(content)];
    });
    return places;
  }

  std::vector<LogOdds> values;

 private:
  static std::size_t index_of(Content content) { return static_cast<std::uint16_t>(content); }

  void mark(Content content) {
    if (content == kNothing || places_[index_of(content)] != 0) return;
    places_[index_of(content)] = 1;
    values.push_back(static_cast<LogOdds>(content));
  }

  std::vector<Place> places_ = std::vector<Place>(std::size_t{1} << 16);
};

/// Kinds, palette, the ground of slots that know anything, the highest place of mixed ones.
void put_slots(const FastContent& tile, const Palette& palette, ByteWriter& out) {
  out.put_varint(palette.values.size());
  for (const LogOdds value : palette.values) out.put(value);
  out.put_bytes(tile.kinds);
  put_places(palette.places_of(tile.ground), is_wide(palette.values), out);
  put_places(palette.places_of(tile.highest), is_wide(palette.values), out);
}

Status get_palette(ByteReader& in, std::vector<LogOdds>& palette) {
  const auto size = in.get_varint();
  if (size > 65'535) return corrupt("a palette of values:", size);
  for (std::uint64_t i = 0; i < size; ++i) {
    palette.push_back(in.get<LogOdds>());
    if (i > 0 && palette[i] <= palette[i - 1]) return corrupt("a palette that falls at", i);
  }
  return {};
}

Status get_slots(ByteReader& in, Pyramid& pyramid) {
  if (auto ok = get_palette(in, pyramid.palette); !ok) return ok;
  const ByteView kinds = in.get_bytes(kBricks);
  if (const auto kind = PlaceReader::largest_byte(kinds); kind > 2) {
    return corrupt("a slot of kind", kind);
  }
  const auto count_of_kind = [&](Kind kind) {
    return static_cast<std::size_t>(
        std::count(kinds.begin(), kinds.end(), static_cast<std::uint8_t>(kind)));
  };
  const std::size_t mixed = count_of_kind(Kind::kMixed);
  const std::size_t known = mixed + count_of_kind(Kind::kUniform);
  const bool wide = is_wide(pyramid.palette);
  const PlaceReader ground(in, known, wide), highest(in, mixed, wide);
  if (!in.ok()) return corrupt("slots: too short for", known);
  std::size_t at = 0, at_mixed = 0;
  for (std::size_t i = 0; i < kBricks; ++i) {
    auto& slot = pyramid.slots[i];
    slot.kind = static_cast<Kind>(kinds[i]);
    if (slot.kind == Kind::kEmpty) continue;
    const auto own = ground.at(at++);
    const bool is_mixed = slot.kind == Kind::kMixed;
    const auto top = is_mixed ? highest.at(at_mixed++) : own;
    if (own > pyramid.palette.size() || top > pyramid.palette.size() || top == kUnknown) {
      return corrupt("a place beyond the palette:", own);
    }
    slot.ground = static_cast<Place>(own);
    slot.highest = static_cast<Place>(top);
  }
  return {};
}

/// Stands beside the number of bricks left out before a coloured one.
constexpr unsigned kUniform = 0x8000;

void put_brick_colours(const TileColours& colours, ByteWriter& out) {
  out.put_varint(colours.bricks.size());
  unsigned least = 0;
  for (const auto& brick : colours.bricks) {
    out.put(static_cast<std::uint16_t>((brick.brick - least) | (brick.uniform ? kUniform : 0u)));
    least = brick.brick + 1;
    out.put(static_cast<std::uint16_t>(brick.voxels));
    put_colour(brick.mean, out);
  }
}

Status get_brick_colours(ByteReader& in, const Pyramid& pyramid, TileColours& colours) {
  const auto count = in.get_varint();
  if (count > kBricks) return corrupt("coloured bricks:", count);
  unsigned least = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    auto& brick = colours.bricks.emplace_back();
    const unsigned number = in.get<std::uint16_t>();
    brick.brick = least + (number & ~kUniform);
    brick.uniform = (number & kUniform) != 0;
    brick.voxels = in.get<std::uint16_t>();
    const bool whole = get_colour(in, brick.mean);
    if (!whole || brick.brick >= kBricks || brick.voxels == 0 || brick.voxels > kBrickVoxels) {
      return corrupt("a colour of brick", brick.brick);
    }
    const auto& slot = pyramid.slots[brick.brick];
    const bool occupied =
        slot.highest != kUnknown && is_occupied(pyramid.palette[slot.highest - 1u]);
    if (!occupied || (brick.uniform && slot.kind != Kind::kUniform)) {
      return corrupt("a colour that cannot be, of brick", brick.brick);
    }
    least = brick.brick + 1;
  }
  return {};
}

void put_voxel_colours(const TileColours& colours, ByteWriter& out) {
  for (const auto& brick : colours.bricks) {
    if (brick.uniform) continue;
    VoxelMask mask{};
    for (unsigned voxel = 0; voxel < kBrickVoxels; ++voxel) {
      const bool has = brick.colours[kMortonOfVoxel[voxel]].exists();
      mask[voxel >> 6] |= std::uint64_t{has ? 1u : 0u} << (voxel & 63);
    }
    for (const auto word : mask) out.put(word);
    for_each_bit(mask,
                 [&](unsigned voxel) { put_colour(brick.colours[kMortonOfVoxel[voxel]], out); });
  }
}

VoxelMask get_mask(ByteReader& in) {
  VoxelMask mask;
  for (auto& word : mask) word = in.get<std::uint64_t>();
  return mask;
}

std::size_t bits_of(ByteView masks) {
  std::size_t count = 0;
  for (std::size_t at = 0; at + kMaskBytes <= masks.size(); at += kMaskBytes) {
    VoxelMask mask;
    std::memcpy(mask.data(), masks.data() + at, sizeof mask);
    count += count_of(mask);
  }
  return count;
}

/// The places of all voxels that are not their brick's ground, none beyond the palette.
Result<PlaceReader> get_places(ByteReader& in, ByteView masks, std::size_t palette) {
  const std::size_t count = bits_of(masks);
  PlaceReader places(in, count, palette > kNarrow);
  if (!in.ok()) return corrupt("voxels: too short for", count);
  if (places.largest() > palette) return corrupt("a voxel of place", places.largest());
  return places;
}

/// The bricks, of what next() gives for one exception after the other. Each is settled, as no
/// encoder, but anybody else, may have written one of equal voxels.
template <class Next>
void fill_bricks(const Pyramid& pyramid, ByteView masks, Next next, BrickTable& table) {
  const auto values = pyramid.values();
  const std::uint8_t* mask = masks.data();
  for (unsigned i = 0; i < kBricks; ++i) {
    const auto& slot = pyramid.slots[i];
    if (slot.kind == Kind::kUniform) table.make_uniform(i, {values[slot.ground], {}});
    if (slot.kind != Kind::kMixed) continue;
    fill_brick(table.expand(i), slot.ground, mask, values, [&](unsigned) { return next(); });
    table.settle(i);
    mask += kMaskBytes;
  }
}

Status get_voxels(ByteReader& in, const Pyramid& pyramid, BrickTable& table) {
  const auto mixed = static_cast<std::size_t>(
      std::count_if(pyramid.slots.begin(), pyramid.slots.end(),
                    [](const auto& slot) { return slot.kind == Kind::kMixed; }));
  const ByteView masks = in.get_bytes(mixed * kMaskBytes);
  auto places = get_places(in, masks, pyramid.palette.size());
  if (!places) return pass_on(places);
  std::size_t at = 0;
  if (places->wide()) {
    fill_bricks(
        pyramid, masks, [&] { return places->both(at++); }, table);
  } else {
    fill_bricks(
        pyramid, masks, [&] { return places->low(at++); }, table);
  }
  return {};
}

Status get_voxel_colours(ByteReader& in, const TileColours& colours, BrickTable& table) {
  for (const auto& from : colours.bricks) {
    if (from.uniform) {
      table.make_uniform(from.brick, {table.uniform_log_odds(from.brick), from.mean});
      continue;
    }
    const VoxelMask mask = get_mask(in);
    std::vector<Colour> own(count_of(mask));
    bool whole = in.ok() && own.size() == from.voxels;
    const Brick& brick = table.expand(from.brick);  // One of equal log-odds, maybe.
    for_each_bit(mask, [&](unsigned voxel) {
      whole = whole && has_voxel(brick.known, voxel) && is_occupied(brick.log_odds[voxel]);
    });
    for (auto& colour : own) whole = whole && get_colour(in, colour);
    if (!whole) return corrupt("a colour in brick", from.brick);
    table.colours_of(from.brick) = BrickColours(mask, std::move(own));
    table.settle(from.brick);
  }
  return {};
}

}  // namespace

FastParts encode_fast(const TileTree& tree) {
  FastParts parts;
  if (tree.empty()) return parts;
  const auto content = fast_content_of(*tree.bricks());
  const auto colours = colours_of(*tree.bricks());
  const Palette palette(content);
  VOX_CHECK(palette.values.size() < std::size_t{1} << 16);
  ByteWriter head(parts.head), body(parts.body);
  put_slots(content, palette, head);
  put_brick_colours(colours, head);
  body.put_bytes(content.masks);
  put_places(palette.places_of(content.exceptions), is_wide(palette.values), body);
  put_voxel_colours(colours, body);
  return parts;
}

Result<FastHead> decode_fast_head(ByteView head) {
  ByteReader in(head);
  FastHead result;
  if (head.empty()) return result;
  if (auto ok = get_slots(in, result.pyramid); !ok) return pass_on(ok);
  if (auto ok = get_brick_colours(in, result.pyramid, result.colours); !ok) return pass_on(ok);
  if (!in.at_end()) return corrupt("its head is read up to", in.position());
  return result;
}

Result<TileTree> decode_fast(ByteView head, ByteView body) {
  auto parsed = decode_fast_head(head);
  if (!parsed) return pass_on(parsed);
  ByteReader in(body);
  BrickTable table;
  if (auto ok = get_voxels(in, parsed->pyramid, table); !ok) return pass_on(ok);
  if (auto ok = get_voxel_colours(in, parsed->colours, table); !ok) return pass_on(ok);
  if (!in.at_end()) return corrupt("its body is read up to", in.position());
  return TileTree::of_bricks(std::move(table));
}

}  // namespace voxatlas
