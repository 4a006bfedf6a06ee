#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace voxatlas {

/// Pixels, from first to last on each axis, both included.
struct PixelRect {
  int xa, ya, xb, yb;
};

/// Which pixels of a strip of the picture are drawn already, so that whole branches of a tree
/// behind them are passed over at a look.
///
/// Layout: a word for each block of 8x8 pixels, pixel (x, y) of it bit 8 y + x; above it a word for
///         each 8x8 blocks, a bit for each full one. Rects are in pixels of the strip and within
///         it.
class Coverage {
 public:
  static constexpr int kBlock = 8;
  static constexpr std::uint64_t kFull = ~std::uint64_t{0};

  /// Nothing drawn; of the blocks that reach past the strip, what is outside counts as drawn.
  void reset(int width, int height);

  int blocks_x() const { return blocks_x_; }
  int blocks_y() const { return blocks_y_; }
  std::size_t block_index(int bx, int by) const {
    return static_cast<std::size_t>(by) * static_cast<std::size_t>(blocks_x_) +
           static_cast<std::size_t>(bx);
  }
  std::uint64_t drawn(std::size_t block) const { return drawn_[block]; }

  void draw(int bx, int by, std::uint64_t pixels) {
    std::uint64_t& word = drawn_[block_index(bx, by)];
    word |= pixels;
    if (word == kFull) full_[group_index(bx >> 3, by >> 3)] |= bit(bx & 7, by & 7);
  }

  /// True where every pixel of the rect is drawn.
  bool covers(const PixelRect& rect) const {
    const PixelRect blocks{rect.xa >> 3, rect.ya >> 3, rect.xb >> 3, rect.yb >> 3};
    if (blocks.xa == blocks.xb && blocks.ya == blocks.yb) {  // Most are as small.
      const std::uint64_t drawn = drawn_[block_index(blocks.xa, blocks.ya)];
      return (within(rect, blocks.xa, blocks.ya) & ~drawn) == 0;
    }
    for (int gy = blocks.ya >> 3; gy <= blocks.yb >> 3; ++gy) {
      for (int gx = blocks.xa >> 3; gx <= blocks.xb >> 3; ++gx) {
        std::uint64_t open = within(blocks, gx, gy) & ~full_[group_index(gx, gy)];
        for (; open != 0; open &= open - 1) {
          const int at = std::countr_zero(open);
          const int bx = gx * 8 + (at & 7), by = gy * 8 + (at >> 3);
          if ((within(rect, bx, by) & ~drawn_[block_index(bx, by)]) != 0) return false;
        }
      }
    }
    return true;
  }

  /// Those bits of the 8x8 items of block (bx, by) that lie in a rect of items; the block must
  /// touch the rect.
  static std::uint64_t within(const PixelRect& rect, int bx, int by) {
    const int xa = rect.xa > bx * 8 ? rect.xa & 7 : 0, xb = rect.xb < bx * 8 + 7 ? rect.xb & 7 : 7;
    const int ya = rect.ya > by * 8 ? rect.ya & 7 : 0, yb = rect.yb < by * 8 + 7 ? rect.yb & 7 : 7;
    const std::uint64_t row = (0xffu >> (7 - xb)) & (0xffu << xa) & 0xffu;
    return row * 0x0101010101010101u & kFull >> 8 * (7 - yb) & kFull << 8 * ya;
  }

 private:
  static std::uint64_t bit(int x, int y) { return std::uint64_t{1} << (8 * y + x); }
  std::size_t group_index(int gx, int gy) const {
    return static_cast<std::size_t>(gy) * static_cast<std::size_t>(groups_x_) +
           static_cast<std::size_t>(gx);
  }

  int blocks_x_ = 0, blocks_y_ = 0, groups_x_ = 0;
  std::vector<std::uint64_t> drawn_, full_;
};

inline void Coverage::reset(int width, int height) {
  const auto up = [](int n) { return (n + 7) / 8; };
  blocks_x_ = up(width);
  blocks_y_ = up(height);
  groups_x_ = up(blocks_x_);
  const auto count = [](int x, int y) {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(y);
  };
  drawn_.assign(count(blocks_x_, blocks_y_), 0);
  full_.assign(count(groups_x_, up(blocks_y_)), 0);
  const PixelRect strip{0, 0, width - 1, height - 1};
  for (int by = 0; by < blocks_y_; ++by) draw(blocks_x_ - 1, by, ~within(strip, blocks_x_ - 1, by));
  for (int bx = 0; bx < blocks_x_; ++bx) draw(bx, blocks_y_ - 1, ~within(strip, bx, blocks_y_ - 1));
}

}  // namespace voxatlas
