#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

#include "codec/pyramid.hpp"
#include "codec/range_coder.hpp"

namespace voxatlas {

namespace detail {

/// A number for each multiset of three views 0..6: mirrored and turned neighbourhoods are alike.
constexpr std::array<std::uint8_t, 343> make_sorted() {
  std::array<std::uint8_t, 343> numbers{};
  unsigned next = 0;
  for (unsigned a = 0; a < 7; ++a) {
    for (unsigned b = a; b < 7; ++b) {
      for (unsigned c = b; c < 7; ++c, ++next) {
        const auto number = static_cast<std::uint8_t>(next);
        numbers[a + 7 * b + 49 * c] = numbers[a + 7 * c + 49 * b] = number;
        numbers[b + 7 * a + 49 * c] = numbers[b + 7 * c + 49 * a] = number;
        numbers[c + 7 * a + 49 * b] = numbers[c + 7 * b + 49 * a] = number;
      }
    }
  }
  return numbers;
}

}  // namespace detail

/// How a Pyramid becomes bits and bits a Pyramid: which chance each bit is coded with, in which
/// order. One text serves both sides, so they cannot disagree: a RangeEncoder codes what the
/// pyramid holds, and a RangeDecoder puts there what it reads. FORMAT.md, "dense".
///
/// Order: depth 4 (every slot), then depths 5, 6, 7, so that a reader may stop at any of them.
/// Errors: after decoding, broken() tells that the bits are not an encoder's. Nothing is read or
///         written out of bounds whatever they are.
template <class Coder>
class PyramidModel {
 public:
  PyramidModel(Coder& coder, Pyramid& pyramid)
      : coder_(coder),
        pyramid_(pyramid),
        tree_bits_(static_cast<unsigned>(std::bit_width(pyramid.palette.size() - 1))),
        trees_(std::size_t{kTrees} << tree_bits_) {}

  void code_slots() {
    for (unsigned i = 0; i < kBricks && !broken_; ++i) code_slot(i);
    if (Coder::kDecodes) add_bricks();
  }

  /// Depth 5, 6 or 7; those above are there.
  void code_depth(int depth) {
    for (unsigned i = 0; i < kBricks && !broken_; ++i) {
      if (pyramid_.slots[i].kind == Kind::kMixed) code_brick(i, depth);
    }
  }

  bool broken() const { return broken_; }

 private:
  using Kind = Pyramid::Kind;

  // Trees of chances by which a place is coded: two for the ground of a slot, two for its highest
  // place, nine for each depth 5..7.
  static constexpr unsigned kGroundTree = 0, kHighestTree = 2, kCellTree = 4, kTrees = 31;

  /// A parent cell and what stands around it, one parent away along each axis.
  struct Family {
    PyramidBrick& brick;
    int depth;             ///< Of the children.
    unsigned parent;       ///< Its number in the brick.
    unsigned mask_at;      ///< Of its exceptions.
    unsigned children_at;  ///< In `highest`.
    Place highest;         ///< The parent's.
    /// Towards lower coordinates, coded already: the children there, if it is an exception.
    std::array<std::uint8_t, 3> lower_mask{};
    std::array<const Place*, 3> lower{};
    /// Is the parent there an exception: towards lower and towards higher coordinates.
    std::array<bool, 3> lower_parent{}, higher_parent{};
  };

  bool bit(Chance& chance, bool value) { return coder_.code(chance, value); }

  /// One of the palette's places. A decoder may meet one beyond: broken.
  Place code_place(unsigned tree, Place place) {
    const unsigned value = place - 1u;
    Chance* chances = trees_.data() + (std::size_t{tree} << tree_bits_);
    unsigned node = 1;
    for (unsigned k = tree_bits_; k-- > 0;) {
      node = 2 * node + (bit(chances[node], (value >> k & 1) != 0) ? 1 : 0);
    }
    const unsigned read = node - (1u << tree_bits_);
    if (read >= pyramid_.palette.size()) {
      broken_ = true;
      return 1;
    }
    return static_cast<Place>(read + 1);
  }

  /// The slot one brick lower along an axis; nullptr at the tile's border.
  const Pyramid::Slot* lower_slot(unsigned slot, unsigned axis) const {
    const unsigned along = 0x249u << axis;
    if ((slot & along) == 0) return nullptr;
    return &pyramid_.slots[(((slot & along) - 1) & along) | (slot & ~along)];
  }

  void code_slot(unsigned i) {
    auto& slot = pyramid_.slots[i];
    std::array<Pyramid::Slot, 3> lower{};
    unsigned kinds = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto* there = lower_slot(i, axis);
      if (there != nullptr) lower[axis] = *there;
      kinds = kinds << 2 | (there != nullptr ? static_cast<unsigned>(there->kind) : 3u);
    }
    auto& chances = slot_kind_[kinds];
    if (bit(chances[0], slot.kind == Kind::kEmpty)) {
      slot.kind = Kind::kEmpty;
      return;
    }
    const bool mixed = bit(chances[1], slot.kind == Kind::kMixed);
    slot.kind = mixed ? Kind::kMixed : Kind::kUniform;
    slot.ground = code_ground(lower, mixed, slot.ground);
    slot.highest = mixed ? code_highest(lower, slot) : slot.ground;
    if (Coder::kDecodes && mixed) slot.mixed = mixed_++;
  }

  /// At once: a vector of them that grows is copied again and again.
  void add_bricks() {
    pyramid_.bricks.resize(mixed_);
    for (const auto& slot : pyramid_.slots) {
      if (slot.kind != Kind::kMixed) continue;
      auto& brick = pyramid_.bricks[slot.mixed];
      brick.ground = slot.ground;
      brick.highest.fill(slot.ground);
      brick.highest[0] = slot.highest;
    }
  }

  /// Unknown or not; then: as one of the three lower slots, each different one asked once; else by
  /// its place.
  Place code_ground(const std::array<Pyramid::Slot, 3>& lower, bool mixed, Place ground) {
    unsigned alike = 0, unknown = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      alike |= (lower[axis].ground == lower[(axis + 1) % 3].ground ? 1u : 0u) << axis;
      unknown |= (lower[axis].ground == kUnknown ? 1u : 0u) << axis;
    }
    if (mixed && bit(ground_unknown_[unknown], ground == kUnknown)) return kUnknown;
    unsigned asked = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const Place candidate = lower[axis].ground;
      bool before = candidate == kUnknown;
      for (unsigned k = 0; k < axis; ++k) before |= lower[k].ground == candidate;
      if (before) continue;
      if (bit(ground_alike_[(mixed ? 24 : 0) + 8 * asked + alike], ground == candidate)) {
        return candidate;
      }
      ++asked;
    }
    return code_place(kGroundTree + (mixed ? 1 : 0), ground);
  }

  Place code_highest(const std::array<Pyramid::Slot, 3>& lower, const Pyramid::Slot& slot) {
    const auto top = static_cast<Place>(pyramid_.palette.size());
    unsigned mixed = 0, at_top = 0;
    for (const auto& there : lower) {
      if (there.kind != Kind::kMixed) continue;
      ++mixed;
      at_top += there.highest == top ? 1 : 0;
    }
    const bool bare = slot.ground == kUnknown;
    if (bit(highest_top_[(bare ? 16 : 0) + 4 * mixed + at_top], slot.highest == top)) return top;
    return code_place(kHighestTree + (bare ? 1 : 0), slot.highest);
  }

  /// The brick one lower (or higher) along an axis, where that is mixed.
  const PyramidBrick* beside(unsigned slot, unsigned axis, bool higher) const {
    const unsigned along = 0x249u << axis;
    if ((slot & along) == (higher ? along : 0)) return nullptr;
    const unsigned moved = higher ? (slot | ~along) + 1 : (slot & along) - 1;
    const auto& there = pyramid_.slots[(moved & along) | (slot & ~along)];
    return there.kind == Kind::kMixed ? &pyramid_.bricks[there.mixed] : nullptr;
  }

  void code_brick(unsigned slot, int depth) {
    auto& brick = pyramid_.bricks[pyramid_.slots[slot].mixed];
    std::array<const PyramidBrick*, 3> lower, higher;
    for (unsigned axis = 0; axis < 3; ++axis) {
      lower[axis] = beside(slot, axis, false);
      higher[axis] = beside(slot, axis, true);
    }
    const unsigned parents = 1u << 3 * (depth - 1 - kBrickDepth);
    for (unsigned parent = 0; parent < parents; ++parent) {
      if (!is_exception(brick, depth - 1, parent)) continue;
      Family family{brick,
                    depth,
                    parent,
                    PyramidBrick::first(depth - 1) + parent,
                    PyramidBrick::first(depth) + 8 * parent,
                    brick.highest[PyramidBrick::first(depth - 1) + parent]};
      for (unsigned axis = 0; axis < 3; ++axis) look_around(family, axis, parents, lower, higher);
      code_exceptions(family);
      code_highest_of(family);
    }
  }

  static bool is_exception(const PyramidBrick& brick, int depth, unsigned cell) {
    if (depth == kBrickDepth) return true;
    return (brick.exceptions[PyramidBrick::first(depth - 1) + cell / 8] >> cell % 8 & 1) != 0;
  }

  static void look_around(Family& family, unsigned axis, unsigned parents,
                          const std::array<const PyramidBrick*, 3>& lower,
                          const std::array<const PyramidBrick*, 3>& higher) {
    const unsigned along = (0x249u << axis) & (parents - 1);
    const unsigned rest = family.parent & ~along;
    const bool at_low = (family.parent & along) == 0, at_high = (family.parent & along) == along;
    const int above = family.depth - 1;
    const PyramidBrick* down = at_low ? lower[axis] : &family.brick;
    const PyramidBrick* up = at_high ? higher[axis] : &family.brick;
    const unsigned down_cell = (((family.parent & along) - 1) & along) | rest;
    const unsigned up_cell = (((family.parent | ~along) + 1) & along) | rest;
    if (down != nullptr && is_exception(*down, above, down_cell)) {
      family.lower_parent[axis] = true;
      family.lower_mask[axis] = down->exceptions[PyramidBrick::first(above) + down_cell];
      family.lower[axis] = down->highest.data() + PyramidBrick::first(family.depth) + 8 * down_cell;
    }
    family.higher_parent[axis] = up != nullptr && is_exception(*up, above, up_cell);
  }

  /// What is seen along one axis from a child, 0..6.
  static unsigned view(const Family& family, unsigned octant, unsigned axis, unsigned mask) {
    const unsigned other = octant ^ 1u << axis;
    if ((octant >> axis & 1) == 0) {
      if ((family.lower_mask[axis] >> other & 1) != 0) return 2;
      return family.lower_parent[axis] ? 1 : 0;
    }
    return 3 + 2 * (mask >> other & 1) + (family.higher_parent[axis] ? 1u : 0u);
  }

  void code_exceptions(Family& family) {
    const unsigned truth = family.brick.exceptions[family.mask_at];
    const bool bare = family.brick.ground == kUnknown;
    auto& chances = exception_[static_cast<unsigned>(family.depth - 5) * 2 + (bare ? 1 : 0)];
    unsigned mask = 0, set = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
      bool one = true;  // A parent without any would be none itself.
      if (octant < 7 || set > 0) {
        const unsigned views = view(family, octant, 0, mask) + 7 * view(family, octant, 1, mask) +
                               49 * view(family, octant, 2, mask);
        one = bit(chances[kSorted[views]][std::min(set, 3u)], (truth >> octant & 1) != 0);
      }
      mask |= (one ? 1u : 0u) << octant;
      set += one ? 1 : 0;
    }
    family.brick.exceptions[family.mask_at] = static_cast<std::uint8_t>(mask);
  }

  /// Of the lower neighbours of a child (siblings among them) that are exceptions: how many, and
  /// how many reach the parent's highest place. 4 * all + reaching.
  unsigned neighbours(const Family& family, unsigned octant, unsigned mask) const {
    unsigned all = 0, reaching = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const unsigned other = octant ^ 1u << axis;
      const bool sibling = (octant >> axis & 1) != 0;
      if (((sibling ? mask : family.lower_mask[axis]) >> other & 1) == 0) continue;
      const Place* there =
          sibling ? family.brick.highest.data() + family.children_at : family.lower[axis];
      ++all;
      reaching += there[other] >= family.highest ? 1 : 0;
    }
    return 4 * all + reaching;
  }

  void code_highest_of(Family& family) {
    const unsigned mask = family.brick.exceptions[family.mask_at];
    const Place ground = family.brick.ground;
    Place* children = family.brick.highest.data() + family.children_at;
    auto left = static_cast<unsigned>(std::popcount(mask));
    bool reached = left < 8 && ground == family.highest;
    const bool taken = family.depth == kDepth && ground == family.highest;
    const unsigned top_class =
        family.highest == pyramid_.palette.size()                                          ? 2u
        : family.highest != kUnknown && is_occupied(pyramid_.palette[family.highest - 1u]) ? 1u
                                                                                           : 0u;
    Place before = kUnknown;
    for (unsigned octant = 0; octant < 8; ++octant) {
      if ((mask >> octant & 1) == 0) continue;
      --left;
      bool reaches = left == 0 && !reached;
      if (!reaches && !taken) {
        const unsigned context =
            (left * 2 + (reached ? 1 : 0)) * 16 + neighbours(family, octant, mask);
        reaches = bit(reaches_[static_cast<unsigned>(family.depth - 5) * 3 + top_class][context],
                      children[octant] == family.highest);
      }
      if (reaches) {
        children[octant] = family.highest;
        reached = true;
      } else {
        children[octant] = code_lower(family, top_class, before, children[octant]);
        if (children[octant] >= family.highest) broken_ = true;
      }
      if (family.depth == kDepth && children[octant] == ground) broken_ = true;
    }
    if (!reached) broken_ = true;
  }

  /// A child that stays below its parent: unknown, as the one before, or by its place.
  Place code_lower(const Family& family, unsigned top_class, Place& before, Place place) {
    const Place ground = family.brick.ground;
    const unsigned ground_class = ground == kUnknown ? 0 : ground == 1 ? 1 : 2;
    const auto depth = static_cast<unsigned>(family.depth - 5);
    const unsigned context = 3 * top_class + ground_class;
    if (ground != kUnknown && bit(unknown_[3 * depth + ground_class], place == kUnknown)) {
      return kUnknown;
    }
    if (before != kUnknown && bit(as_before_[9 * depth + context], place == before)) return before;
    return before = code_place(kCellTree + 9 * depth + context, place);
  }

  static constexpr auto kSorted = detail::make_sorted();

  Coder& coder_;
  Pyramid& pyramid_;
  bool broken_ = false;
  std::uint16_t mixed_ = 0;  ///< Slots read so far that are.

  std::array<std::array<Chance, 2>, 64> slot_kind_;
  std::array<Chance, 8> ground_unknown_;
  std::array<Chance, 48> ground_alike_;
  std::array<Chance, 32> highest_top_;
  std::array<std::array<std::array<Chance, 4>, 84>, 6> exception_;
  std::array<std::array<Chance, 256>, 9> reaches_;
  std::array<Chance, 9> unknown_;
  std::array<Chance, 27> as_before_;
  unsigned tree_bits_;
  std::vector<Chance> trees_;
};

}  // namespace voxatlas
