#include "codec/paper_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/check.hpp"
#include "base/crc32c.hpp"
#include "codec/bits.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kMagic = 0x52505856;  // "VXPR".
constexpr std::size_t kHeaderBytes = 17;

/// Bits of one node's parts.
struct Widths {
  unsigned leaf_bit, probability, channel;
  bool inner_probability, inner_colour, leaf_children;
};

Widths widths_of(const PaperOptions& options) {
  const bool lossy = options.format == PaperFormat::kLossy;
  Widths widths{1,
                lossy ? static_cast<unsigned>(options.bits) : 32u,
                lossy ? static_cast<unsigned>(options.colour_bits) : 8u,
                false,
                false,
                false};
  if (options.format == PaperFormat::kInnerColour) widths.inner_colour = true;
  if (options.format == PaperFormat::kRaw) widths = {0, 32, 8, true, true, true};
  return widths;
}

bool is_valid(const PaperOptions& options) {
  const auto format = static_cast<int>(options.format);
  const auto quantizer = static_cast<int>(options.quantizer);
  return format >= 1 && format <= 4 && quantizer >= 1 && quantizer <= 2 && options.bits >= 1 &&
         options.bits <= 32 && options.colour_bits >= 1 && options.colour_bits <= 8 &&
         options.model.clamp_min < 0 && options.model.clamp_max >= 0;
}

std::uint32_t level_of(double probability, const PaperOptions& options) {
  const double levels = std::exp2(options.bits);
  double level;
  if (options.quantizer == PaperQuantizer::kUnit) {
    level = std::floor(probability * levels);
  } else {
    const double low = to_probability(options.model.clamp_min);
    const double high = to_probability(options.model.clamp_max);
    level = std::round((probability - low) / (high - low) * (levels - 1));
  }
  return static_cast<std::uint32_t>(std::clamp(level, 0.0, levels - 1));
}

double probability_of(std::uint32_t level, const PaperOptions& options) {
  const double levels = std::exp2(options.bits);
  if (options.quantizer == PaperQuantizer::kUnit) return (level + 0.5) / levels;
  const double low = to_probability(options.model.clamp_min);
  const double high = to_probability(options.model.clamp_max);
  return low + (high - low) * level / (levels - 1);
}

/// One node's payload, to bits and back.
class Payload {
 public:
  explicit Payload(const PaperOptions& options) : options_(options), widths_(widths_of(options)) {}

  void put_probability(LogOdds log_odds, BitWriter& out) const {
    const double probability = to_probability(log_odds);
    if (options_.format == PaperFormat::kLossy) {
      out.put(level_of(probability, options_), widths_.probability);
    } else {
      out.put(std::bit_cast<std::uint32_t>(static_cast<float>(probability)), 32);
    }
  }

  bool get_probability(BitReader& in, LogOdds& log_odds) const {
    const std::uint32_t bits = in.get(widths_.probability);
    const double probability = options_.format == PaperFormat::kLossy
                                   ? probability_of(bits, options_)
                                   : double{std::bit_cast<float>(bits)};
    const auto value = to_log_odds(probability);
    if (!value) return false;
    log_odds = *value;
    return in.ok();
  }

  void put_colour(const Colour& colour, BitWriter& out) const {
    Rgb rgb{255, 255, 255};
    if (colour.exists() && colour.rgb() != rgb) {
      rgb = colour.rgb();
    } else if (colour.exists()) {
      rgb = {254, 254, 254};
    }
    const unsigned most = (1u << widths_.channel) - 1;
    for (const unsigned channel : {rgb.r, rgb.g, rgb.b}) {
      out.put((2 * channel * most + 255) / 510, widths_.channel);
    }
  }

  Colour get_colour(BitReader& in, bool occupied) const {
    const unsigned most = (1u << widths_.channel) - 1;
    std::array<std::uint8_t, 3> rgb;
    for (auto& channel : rgb) {
      channel = static_cast<std::uint8_t>((2 * in.get(widths_.channel) * 255 + most) / (2 * most));
    }
    Colour colour;
    const bool none = rgb[0] == 255 && rgb[1] == 255 && rgb[2] == 255;
    if (occupied && !none) colour.add({rgb[0], rgb[1], rgb[2]});
    return colour;
  }

 private:
  PaperOptions options_;
  Widths widths_;
};

class Writer {
 public:
  Writer(const TileTree& tree, const PaperOptions& options, bool expanded, Bytes& out)
      : tree_(tree), widths_(widths_of(options)), payload_(options), out_(out) {
    tree.for_each_leaf([&](const Leaf& leaf) { add(leaf, expanded); });
  }

  void write() { node(CellKey{}, 0, leaves_.size()); }

 private:
  void add(const Leaf& leaf, bool expanded) {
    const int below = expanded ? kDepth - leaf.cell.depth : 0;
    for (std::uint32_t i = 0; i < 1u << 3 * below; ++i) {
      leaves_.push_back(
          {{static_cast<std::uint8_t>(leaf.cell.depth + below), leaf.cell.code << 3 * below | i},
           leaf.state});
    }
  }

  /// The leaves [begin, end) are all of the cell.
  void node(CellKey cell, std::size_t begin, std::size_t end) {
    const bool is_leaf = leaves_[begin].cell.depth == cell.depth;
    out_.put(is_leaf ? 1 : 0, widths_.leaf_bit);
    const bool whole = is_leaf || widths_.inner_probability || widths_.inner_colour;
    const CellState state = is_leaf ? leaves_[begin].state
                            : whole ? *tree_.cell(cell)
                                    : CellState{};
    if (is_leaf || widths_.inner_probability) payload_.put_probability(state.log_odds, out_);
    if (is_leaf || widths_.inner_colour) payload_.put_colour(state.colour, out_);
    if (is_leaf) {
      out_.put(0, widths_.leaf_children ? 8 : 0);
      return;
    }
    std::array<std::size_t, 9> first{};
    unsigned children = 0;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      first[octant] = begin;
      while (begin < end && cell.child(octant).contains(leaves_[begin].cell)) ++begin;
      children |= (begin > first[octant] ? 1u : 0u) << octant;
    }
    first[8] = begin;
    out_.put(children, 8);
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      if (first[octant + 1] > first[octant]) {
        node(cell.child(octant), first[octant], first[octant + 1]);
      }
    }
  }

  const TileTree& tree_;
  Widths widths_;
  Payload payload_;
  BitWriter out_;
  std::vector<Leaf> leaves_;
};

class Reader {
 public:
  Reader(ByteView bytes, const PaperOptions& options)
      : widths_(widths_of(options)), payload_(options), in_(bytes) {}

  bool read(TileTree& tree) { return node(CellKey{}, tree) && in_.at_end(); }

 private:
  bool node(CellKey cell, TileTree& tree) {
    const bool bare = widths_.leaf_bit == 0;
    bool is_leaf = !bare && in_.get(1) == 1;
    CellState state;
    if (is_leaf || widths_.inner_probability) {
      if (!payload_.get_probability(in_, state.log_odds)) return false;
    }
    if (is_leaf || widths_.inner_colour) {
      state.colour = payload_.get_colour(in_, is_occupied(state.log_odds));
    }
    const unsigned children = is_leaf ? 0 : in_.get(8);
    if (!in_.ok()) return false;
    is_leaf = is_leaf || (bare && children == 0);
    if (is_leaf) {
      tree.set(cell, state);
      return true;
    }
    if (children == 0 || cell.depth == kDepth) return false;
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      if ((children >> octant & 1) != 0 && !node(cell.child(octant), tree)) return false;
    }
    return true;
  }

  Widths widths_;
  Payload payload_;
  BitReader in_;
};

constexpr std::size_t kChecksumAt = 12;

std::uint32_t checksum_of(ByteView bytes) {
  return crc32c(bytes.subspan(kChecksumAt + 4), crc32c(bytes.first(kChecksumAt)));
}

Bytes seal_paper(Bytes bytes) {
  const std::uint32_t checksum = checksum_of(bytes);
  std::memcpy(bytes.data() + kChecksumAt, &checksum, sizeof checksum);
  return bytes;
}

Result<PaperOptions> open_paper(ByteView bytes) {
  ByteReader in(bytes);
  const auto magic = in.get<std::uint32_t>();
  PaperOptions options;
  options.format = static_cast<PaperFormat>(in.get<std::uint8_t>());
  options.quantizer = static_cast<PaperQuantizer>(in.get<std::uint8_t>());
  options.bits = in.get<std::uint8_t>();
  options.colour_bits = in.get<std::uint8_t>();
  options.model.clamp_min = in.get<LogOdds>();
  options.model.clamp_max = in.get<LogOdds>();
  const auto checksum = in.get<std::uint32_t>();
  in.get<std::uint8_t>();
  if (!in.ok() || magic != kMagic || checksum != checksum_of(bytes) || !is_valid(options)) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} bytes do not begin like a tile in the paper's format, or their "
                            "checksum is wrong",
                            bytes.size()));
  }
  return options;
}

}  // namespace

std::uint64_t paper_bits(const TileTree::Counts& counts, const PaperOptions& options) {
  const auto widths = widths_of(options);
  const unsigned colour = 3 * widths.channel;
  const unsigned leaf =
      widths.leaf_bit + widths.probability + colour + (widths.leaf_children ? 8 : 0);
  const unsigned inner = widths.leaf_bit + (widths.inner_probability ? widths.probability : 0) +
                         (widths.inner_colour ? colour : 0) + 8;
  return counts.leaves * leaf + counts.inner * inner;
}

double paper_quantized(double probability, const PaperOptions& options) {
  return probability_of(level_of(probability, options), options);
}

Bytes encode_paper(const TileTree& tree, const PaperOptions& options, bool expanded) {
  VOX_CHECK(is_valid(options));
  Bytes bytes;
  ByteWriter out(bytes);
  out.put(kMagic);
  for (const int value : {static_cast<int>(options.format), static_cast<int>(options.quantizer),
                          options.bits, options.colour_bits}) {
    out.put(static_cast<std::uint8_t>(value));
  }
  out.put(options.model.clamp_min);
  out.put(options.model.clamp_max);
  out.put(std::uint32_t{0});
  out.put(std::uint8_t{tree.empty() ? std::uint8_t{0} : std::uint8_t{1}});
  if (!tree.empty()) Writer(tree, options, expanded, bytes).write();
  return seal_paper(std::move(bytes));
}

Result<TileTree> decode_paper(ByteView bytes) {
  auto options = open_paper(bytes);
  if (!options) return pass_on(options);
  TileTree tree;
  if (bytes[kHeaderBytes - 1] == 0 && bytes.size() == kHeaderBytes) return tree;
  if (bytes[kHeaderBytes - 1] != 1 || !Reader(bytes.subspan(kHeaderBytes), *options).read(tree)) {
    return fail(ErrorCode::kCorrupt, fmt::format("{} bytes are no tile in the paper's format {}",
                                                 bytes.size(), static_cast<int>(options->format)));
  }
  return tree;
}

}  // namespace voxatlas
