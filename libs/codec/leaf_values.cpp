#include "codec/leaf_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace voxatlas {
namespace {

constexpr std::size_t kValues = std::size_t{1} << 16;
/// More distinct values than this need a second byte of index.
constexpr std::size_t kOneByte = 256;

struct PaletteEntry {
  std::uint32_t count = 0;
  LogOdds value = 0;

  /// The palette's order: often before seldom, then low before high.
  bool before(const PaletteEntry& other) const {
    return count != other.count ? count > other.count : value < other.value;
  }
};

std::size_t slot(LogOdds value) { return static_cast<std::uint16_t>(value); }

std::vector<PaletteEntry> palette_of(std::span<const Leaf> leaves) {
  std::vector<std::uint32_t> counts(kValues);
  for (const auto& leaf : leaves) ++counts[slot(leaf.state.log_odds)];
  std::vector<PaletteEntry> palette;
  for (std::size_t i = 0; i < kValues; ++i) {
    if (counts[i] != 0) palette.push_back({counts[i], static_cast<LogOdds>(i)});
  }
  std::sort(palette.begin(), palette.end(),
            [](const auto& a, const auto& b) { return a.before(b); });
  return palette;
}

/// A palette as read, checked once all leaves are counted.
Status check_palette(std::span<const PaletteEntry> palette) {
  for (std::size_t i = 0; i < palette.size(); ++i) {
    if (palette[i].count == 0 || (i > 0 && !palette[i - 1].before(palette[i]))) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("tile: log-odds {} are at the wrong place, {}, of the palette",
                              palette[i].value, i));
    }
  }
  return {};
}

tl::unexpected<Error> too_short(const char* what, std::size_t leaves) {
  return fail(ErrorCode::kCorrupt, fmt::format("tile: {} of {} leaves: too short", what, leaves));
}

/// The six byte planes of colour means: high bytes of r, g, b, then low bytes.
constexpr std::array<unsigned, 2> kShifts{8, 0};

std::vector<Colour> colours_of(std::span<const Leaf> leaves) {
  std::vector<Colour> colours;
  for (const auto& leaf : leaves) {
    if (leaf.state.colour.exists()) colours.push_back(leaf.state.colour);
  }
  return colours;
}

/// Reads counts and means for each of `coloured`.
Status read_means(ByteReader& in, std::span<Colour* const> coloured) {
  for (auto* colour : coloured) {
    colour->count = in.get<std::uint8_t>();
    if (!colour->exists() || colour->count > Colour::kMaxCount) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("tile: a colour seen {} times, not 1..16", colour->count));
    }
  }
  for (const auto shift : kShifts) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const ByteView plane = in.get_bytes(coloured.size());
      if (!in.ok()) return too_short("colours", coloured.size());
      for (std::size_t i = 0; i < coloured.size(); ++i) {
        auto& mean = coloured[i]->mean[channel];
        mean = static_cast<std::uint16_t>(mean | plane[i] << shift);
      }
    }
  }
  return {};
}

}  // namespace

void write_log_odds(std::span<const Leaf> leaves, ByteWriter& out) {
  const auto palette = palette_of(leaves);
  std::vector<std::uint16_t> index(kValues);
  out.put_varint(palette.size());
  for (std::size_t i = 0; i < palette.size(); ++i) {
    out.put(palette[i].value);
    index[slot(palette[i].value)] = static_cast<std::uint16_t>(i);
  }
  Bytes plane(leaves.size());
  for (unsigned shift = 0; shift == 0 || (shift == 8 && palette.size() > kOneByte); shift += 8) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      plane[i] = static_cast<std::uint8_t>(index[slot(leaves[i].state.log_odds)] >> shift);
    }
    out.put_bytes(plane);
  }
}

Status read_log_odds(ByteReader& in, std::span<CellState> states) {
  const auto size = in.get_varint();
  if (size > kValues || size > states.size()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile: a palette of {} values for {} leaves", size, states.size()));
  }
  std::vector<PaletteEntry> palette(size);
  for (auto& entry : palette) entry.value = in.get<LogOdds>();
  const ByteView low = in.get_bytes(states.size());
  const ByteView high = in.get_bytes(size > kOneByte ? states.size() : 0);
  if (!in.ok()) return too_short("log-odds", states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const unsigned index = low[i] | (high.empty() ? 0u : unsigned{high[i]} << 8);
    if (index >= palette.size()) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("tile: value {} of a palette of {}", index, palette.size()));
    }
    states[i].log_odds = palette[index].value;
    ++palette[index].count;
  }
  return check_palette(palette);
}

void write_colours(std::span<const Leaf> leaves, ByteWriter& out) {
  const auto colours = colours_of(leaves);
  out.put_varint(colours.size());
  if (colours.empty()) return;
  Bytes flags;
  std::size_t occupied = 0;
  for (const auto& leaf : leaves) {
    if (!is_occupied(leaf.state.log_odds)) continue;
    if (occupied % 8 == 0) flags.push_back(0);
    if (leaf.state.colour.exists()) {
      flags.back() = static_cast<std::uint8_t>(flags.back() | 1u << occupied % 8);
    }
    ++occupied;
  }
  out.put_bytes(flags);
  for (const auto& colour : colours) out.put(static_cast<std::uint8_t>(colour.count));
  for (const auto shift : kShifts) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      for (const auto& colour : colours) {
        out.put(static_cast<std::uint8_t>(colour.mean[channel] >> shift));
      }
    }
  }
}

Status read_colours(ByteReader& in, std::span<CellState> states) {
  const auto count = in.get_varint();
  if (count == 0) return {};
  std::vector<Colour*> coloured;
  std::size_t occupied = 0;
  unsigned flags = 0;
  for (auto& state : states) {
    if (!is_occupied(state.log_odds)) continue;
    flags = occupied % 8 == 0 ? in.get<std::uint8_t>() : flags >> 1;
    if ((flags & 1) != 0) coloured.push_back(&state.colour);
    ++occupied;
  }
  const bool unused_bits = flags >> 1 != 0;  // What the last flag left of its byte.
  if (!in.ok() || coloured.size() != count || unused_bits) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("tile: {} colours said, {} flagged", count, coloured.size()));
  }
  return read_means(in, coloured);
}

}  // namespace voxatlas
