#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace voxatlas {

/// Pixels, from first to last on each axis, both included.
struct PixelRect {
  int xa, ya, xb, yb;
};

/// Which pixels of a strip of the picture, 64 columns wide, are drawn already, so that whole
/// branches of a tree behind them are passed over at a look.
///
/// Layout: a word a row, pixel x of it bit x. Rects are in pixels of the strip and within it.
class Coverage {
 public:
  static constexpr int kWidth = 64;
  static constexpr std::uint64_t kFull = ~std::uint64_t{0};

  /// Nothing drawn; of a strip that is narrower, what is outside counts as drawn.
  void reset(int width, int height) {
    drawn_.assign(static_cast<std::size_t>(height), width < kWidth ? kFull << width : 0);
  }

  static std::uint64_t columns(const PixelRect& rect) {
    return kFull >> (kWidth - 1 - rect.xb) & kFull << rect.xa;
  }
  /// Those of a row that are not drawn.
  std::uint64_t open(int y, std::uint64_t columns) const {
    return columns & ~drawn_[static_cast<std::size_t>(y)];
  }
  void draw(int y, std::uint64_t pixels) { drawn_[static_cast<std::size_t>(y)] |= pixels; }

  /// True where every pixel of the rect is drawn.
  bool covers(const PixelRect& rect) const {
    constexpr int kAtOnce = 8;  // A branch for many: those that are covered are seen to the end.
    const std::uint64_t within = columns(rect);
    int y = rect.ya;
    for (; y + kAtOnce - 1 <= rect.yb; y += kAtOnce) {
      std::uint64_t left = 0;
      for (int row = 0; row < kAtOnce; ++row) left |= open(y + row, within);
      if (left != 0) return false;
    }
    for (; y <= rect.yb; ++y) {
      if (open(y, within) != 0) return false;
    }
    return true;
  }

 private:
  std::vector<std::uint64_t> drawn_;
};

}  // namespace voxatlas
