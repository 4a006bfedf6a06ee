// Any bytes are refused, or are a tile that says the same when encoded again; in every codec, past
// the checksum too, which stops nearly everything before the decoders.
#include <algorithm>
#include <numeric>

#include "base/check.hpp"
#include "codec/dense_stream.hpp"
#include "codec/fast_stream.hpp"
#include "codec/node_stream.hpp"
#include "codec/paper_format.hpp"
#include "codec/tile_codec.hpp"
#include "codec/tile_header.hpp"

namespace voxatlas {
namespace {

void try_whole(ByteView bytes) {
  if (const auto tree = decode_tile(bytes)) {
    VOX_CHECK(decode_tile(encode_tile(*tree, {})).value() == *tree);
  }
  static_cast<void>(decode_tile_to_depth(bytes, static_cast<int>(bytes.size() % 7)).has_value());
}

void try_dense(ByteView bytes) {
  if (const auto tree = decode_dense(bytes)) {
    VOX_CHECK(decode_dense(encode_dense(*tree)).value() == *tree);
  }
  static_cast<void>(decode_dense(bytes, 5).has_value());
}

/// The first two bytes say where the head ends.
void try_fast(ByteView bytes) {
  if (bytes.size() < 2) return;
  const std::size_t head = std::min<std::size_t>(bytes[0] | bytes[1] << 8, bytes.size() - 2);
  const ByteView rest = bytes.subspan(2);
  if (const auto tree = decode_fast(rest.first(head), rest.subspan(head))) {
    const auto parts = encode_fast(*tree);
    VOX_CHECK(decode_fast(parts.head, parts.body).value() == *tree);
  }
}

void try_nodes(ByteView bytes) {
  if (const auto tree = decode_nodes(bytes)) {
    VOX_CHECK(encode_nodes(*tree) == Bytes(bytes.begin(), bytes.end()));
  }
}

}  // namespace
}  // namespace voxatlas

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace voxatlas;
  const ByteView bytes(data, size);
  try_whole(bytes);
  try_nodes(bytes);
  static_cast<void>(decode_paper(bytes).has_value());
  // The payload of a golden tile that was mutated, its checksum aside.
  const auto header = read_tile_header(bytes);
  if (header && std::accumulate(data, data + size, 0u) % 16 == 0) {  // Slow: one in sixteen.
    try_whole(seal_tile(header->codec, header->payload));
  } else if (!header && size % 2 == 0) {
    try_dense(bytes);
  } else if (!header) {
    try_fast(bytes);
  }
  return 0;
}
