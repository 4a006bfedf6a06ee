// Any bytes, as any type of message: refused, or a message that is the same bytes again.
#include "base/check.hpp"
#include "bus/checkpoint_wire.hpp"

namespace {

using namespace voxatlas;

/// The first byte chose the type; the fingerprint is put before the rest, for it is never guessed.
template <class T>
void try_as(ByteView body) {
  const auto fingerprint = static_cast<std::uint64_t>(T::getHash());
  Bytes bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(fingerprint >> shift));
  }
  bytes.insert(bytes.end(), body.begin(), body.end());
  const auto message = decode_message<T>(bytes);
  if (message) VOX_CHECK(encode_message(*message) == bytes);
}

template <class... Types>
void try_nth(std::size_t n, ByteView body) {
  std::size_t i = 0;
  ((i++ == n ? try_as<Types>(body) : void()), ...);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try_nth<ack_t, camera_t, checkpoint_reply_t, checkpoint_request_t, chunk_t, counter_t, frame_t,
          model_reply_t, model_request_t, render_request_t, scan_delta_t, scan_t, status_t,
          tile_encoded_t, tile_raw_t, tile_reply_t, tile_request_t, tile_update_t, tiles_reply_t,
          tiles_request_t>(data[0] % 20, ByteView(data + 1, size - 1));
  return 0;
}
