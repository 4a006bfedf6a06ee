// Any bytes are refused, or are a tile that says the same when encoded again.
#include "base/check.hpp"
#include "codec/node_stream.hpp"
#include "codec/tile_codec.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace voxatlas;
  const ByteView bytes(data, size);
  if (const auto tree = decode_tile(bytes)) {
    VOX_CHECK(decode_tile(encode_tile(*tree, {})).value() == *tree);
  }
  // Past the checksum, which stops nearly everything above.
  if (const auto tree = decode_nodes(bytes)) {
    const auto again = encode_nodes(*tree);
    VOX_CHECK(again == Bytes(bytes.begin(), bytes.end()));
  }
  return 0;
}
