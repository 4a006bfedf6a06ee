#pragma once

#include <array>

#include "codec/dense_colours.hpp"
#include "codec/pyramid.hpp"
#include "codec/range_coder.hpp"

namespace voxatlas {

/// TileColours as bits and back, like PyramidModel: first what stands for each brick, then, once
/// all log-odds are there, its voxels. FORMAT.md, "dense", "colours".
template <class Coder>
class ColourModel {
 public:
  ColourModel(Coder& coder, const Pyramid& pyramid, TileColours& colours)
      : coder_(coder), pyramid_(pyramid), colours_(colours) {}

  void code_bricks() {
    if (!bit(any_, !colours_.bricks.empty())) return;
    std::size_t next = 0;
    bool before = false;
    for (unsigned i = 0; i < kBricks; ++i) {
      if (!may_be_coloured(pyramid_.slots[i].highest)) continue;
      const bool has = next < colours_.bricks.size() && colours_.bricks[next].brick == i;
      before = bit(coloured_[before ? 1 : 0], has);
      if (!before) continue;
      if (Coder::kDecodes) colours_.bricks.emplace_back().brick = i;
      code_brick(colours_.bricks[next++]);
    }
    if (next == 0) broken_ = true;
  }

  void code_voxels() {
    for (auto& brick : colours_.bricks) {
      if (!brick.uniform) code_voxels_of(brick);
    }
  }

  bool broken() const { return broken_; }

 private:
  using Tree = std::array<Chance, 256>;

  bool bit(Chance& chance, bool value) { return coder_.code(chance, value); }

  bool may_be_coloured(Place place) const {
    return place != kUnknown && is_occupied(pyramid_.palette[place - 1u]);
  }

  unsigned code_number(Tree& tree, unsigned bits, unsigned value) {
    unsigned node = 1;
    for (unsigned k = bits; k-- > 0;) {
      node = 2 * node + (bit(tree[node], (value >> k & 1) != 0) ? 1 : 0);
    }
    return node - (1u << bits);
  }

  void code_brick(ColouredBrick& brick) {
    const auto& slot = pyramid_.slots[brick.brick];
    // All of a mixed brick's voxels may be coloured alike only where all are occupied.
    brick.uniform = slot.kind == Pyramid::Kind::kUniform && bit(uniform_, brick.uniform);
    code_colour(brick.mean, mean_before_, brick_trees_);
    mean_before_ = brick.mean;
    if (brick.uniform) {
      brick.voxels = kBrickVoxels;
      return;
    }
    const unsigned less = brick.voxels - 1;
    const unsigned high = bit(many_, less >> 8 != 0) ? 256 : 0;
    brick.voxels = 1 + high + code_number(voxels_, 8, less & 255);
  }

  void code_voxels_of(ColouredBrick& brick) {
    const auto& slot = pyramid_.slots[brick.brick];
    const Place* places =
        slot.kind == Pyramid::Kind::kMixed ? pyramid_.bricks[slot.mixed].voxels() : nullptr;
    Colour before = brick.mean;
    bool had = true;
    unsigned found = 0;
    for (unsigned code = 0; code < kBrickVoxels && found < brick.voxels; ++code) {
      if (!may_be_coloured(places == nullptr ? slot.ground : places[code])) continue;
      Colour& colour = brick.colours[code];
      had = bit(voxel_[had ? 1 : 0], colour.exists());
      if (!had) continue;
      ++found;
      if (bit(as_before_, colour == before)) {
        colour = before;
      } else {
        code_colour(colour, before, voxel_trees_);
        before = colour;
      }
    }
    if (found != brick.voxels) broken_ = true;
  }

  struct Trees {
    Tree count;
    std::array<Tree, 3> high;                ///< Differences to the colour before.
    std::array<std::array<Tree, 3>, 2> low;  ///< Of colours seen once; of others.
  };

  void code_colour(Colour& colour, const Colour& before, Trees& trees) {
    const unsigned count = code_number(trees.count, 4, (colour.count - 1u) & 15) + 1;
    colour.count = static_cast<std::uint16_t>(count);
    unsigned shift = 0;  // Of the channel before: channels change together.
    for (std::size_t c = 0; c < 3; ++c) {
      const unsigned expected = (before.mean[c] >> 8) + shift;
      const unsigned step = code_number(trees.high[c], 8, ((colour.mean[c] >> 8) - expected) & 255);
      const unsigned high = (expected + step) & 255;
      const unsigned low = code_number(trees.low[count > 1 ? 1 : 0][c], 8, colour.mean[c] & 255);
      colour.mean[c] = static_cast<std::uint16_t>(high << 8 | low);
      shift = high - (before.mean[c] >> 8);
    }
  }

  Coder& coder_;
  const Pyramid& pyramid_;
  TileColours& colours_;
  bool broken_ = false;
  Colour mean_before_;

  Chance any_, uniform_, many_, as_before_;
  std::array<Chance, 2> coloured_, voxel_;
  Tree voxels_;
  Trees brick_trees_, voxel_trees_;
};

}  // namespace voxatlas
