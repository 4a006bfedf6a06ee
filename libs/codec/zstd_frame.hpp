#pragma once

#include <cstddef>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace voxatlas {

/// Appends one Zstandard frame that states its content's size. `level` 1..19.
void zstd_compress(ByteView content, int level, Bytes& out);

/// The content of exactly one frame. Errors: kCorrupt where the frame is damaged, is followed by
/// anything, or does not state `size` as its content's. Memory: `size`, which the caller bounds.
Result<Bytes> zstd_decompress(ByteView frame, std::size_t size);

}  // namespace voxatlas
