#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "octree/colour.hpp"

namespace voxatlas {

class Workers;

/// A picture: eight bits a channel, row by row from the upper left.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;  ///< width x height.

  Image() = default;
  Image(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}

  Rgb& at(int x, int y) { return pixels[index(x, y)]; }
  Rgb at(int x, int y) const { return pixels[index(x, y)]; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};
static_assert(sizeof(Rgb) == 3, "libpng and TurboJPEG read pixels straight from memory");

/// A lossless PNG, compressed quickly rather than well. Errors: kIo where libpng refuses.
Result<Bytes> encode_png(const Image& image);

/// Errors: kCorrupt for what is no PNG, kOutOfRange for a picture of more than 2^25 pixels; others
///         than 8-bit RGB are converted to it.
Result<Image> decode_png(ByteView bytes);

struct Jpeg {
  Bytes bytes;
  int quality = 0;  ///< 1..100, as libjpeg counts it.
};

/// Errors: kCorrupt for what is no JPEG, kOutOfRange for a picture of more than 2^25 pixels.
Result<Image> decode_jpeg(ByteView bytes);

/// A JPEG of at most `max_bytes`: at `quality` if that fits, else at a lower one, which the result
/// states. With `workers` on all of them, to the same bytes. Errors: kOutOfRange where it does not
/// fit even at quality 1; kIo where TurboJPEG refuses.
Result<Jpeg> encode_jpeg(const Image& image, int quality, std::size_t max_bytes,
                         Workers* workers = nullptr);

}  // namespace voxatlas
