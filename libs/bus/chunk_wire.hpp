#pragma once

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// A chunk whose data lie elsewhere, so that they need not be copied to be sent or looked at.
struct ChunkView {
  chunk_t head;   ///< All fields but the data; `size` is theirs.
  ByteView data;  ///< Of the message it is a piece of, or of the bytes it was decoded from.
};

/// Encodes the chunk that `head` and `data` are together into `bytes`, whose memory is used again.
void encode_chunk(const chunk_t& head, ByteView data, Bytes& bytes);

/// What decode_message<chunk_t> does, without copying the data out of `bytes`.
Result<ChunkView> decode_chunk(ByteView bytes);

}  // namespace voxatlas
