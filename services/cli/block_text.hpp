#pragma once

#include <string>

#include "render/image.hpp"

namespace voxatlas {

/// A picture as text for a terminal of 24-bit colours: half-block characters, two pixels each, one
/// above the other, every one the mean of what it covers. Lines end in a reset and a newline.
/// `columns`: as wide as this, 1 or more; the height follows. Empty for an empty picture.
std::string block_text(const Image& image, int columns);

}  // namespace voxatlas
