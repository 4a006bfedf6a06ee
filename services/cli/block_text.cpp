#include "cli/block_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace voxatlas {
namespace {

/// The mean colour of pixel (x, y) of a picture of `width` x `height` that shows `image`.
Rgb mean(const Image& image, int x, int y, int width, int height) {
  const auto from = [](int i, int all, int parts) { return i * all / parts; };
  const int x0 = from(x, image.width, width), y0 = from(y, image.height, height);
  const int x1 = std::max(x0 + 1, from(x + 1, image.width, width));
  const int y1 = std::max(y0 + 1, from(y + 1, image.height, height));
  unsigned r = 0, g = 0, b = 0;
  for (int v = y0; v < y1; ++v) {
    for (int u = x0; u < x1; ++u) {
      const Rgb pixel = image.at(u, v);
      r += pixel.r;
      g += pixel.g;
      b += pixel.b;
    }
  }
  const auto count = static_cast<unsigned>((x1 - x0) * (y1 - y0));
  const auto part = [count](unsigned sum) {
    return static_cast<std::uint8_t>((sum + count / 2) / count);
  };
  return {part(r), part(g), part(b)};
}

}  // namespace

std::string block_text(const Image& image, int columns) {
  if (image.width < 1 || image.height < 1 || columns < 1) return {};
  const int width = std::min(columns, image.width);
  const int lines = std::max(
      1, static_cast<int>(std::lround(width * 0.5 * image.height / std::max(1, image.width))));
  std::string text;
  for (int line = 0; line < lines; ++line) {
    for (int x = 0; x < width; ++x) {
      const Rgb top = mean(image, x, 2 * line, width, 2 * lines);
      const Rgb below = mean(image, x, 2 * line + 1, width, 2 * lines);
      fmt::format_to(std::back_inserter(text), "\033[38;2;{};{};{}m\033[48;2;{};{};{}m\u2580",
                     top.r, top.g, top.b, below.r, below.g, below.b);
    }
    text += "\033[0m\n";
  }
  return text;
}

}  // namespace voxatlas
