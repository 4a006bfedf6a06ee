#include "bus/chunk_wire.hpp"

#include <algorithm>
#include <array>

#include "base/check.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kSizeBytes = 4;
/// A chunk without data: the fingerprint, and the fields as lcmtypes/chunk_t.lcm lists them.
constexpr std::size_t kHeadBytes = 8 + 5 * 8 + 2 * 4 + 2 + 4 + kSizeBytes;

}  // namespace

void encode_chunk(const chunk_t& head, ByteView data, Bytes& bytes) {
  VOX_CHECK(head.data.empty() && static_cast<std::size_t>(head.size) == data.size());
  bytes.resize(static_cast<std::size_t>(head.getEncodedSize()));
  // The data and, before it, its size are the last fields.
  const auto front = bytes.size() - data.size();
  chunk_t without_data = head;
  without_data.size = 0;
  without_data.encode(bytes.data(), 0, static_cast<int>(front));
  for (std::size_t i = 0; i < kSizeBytes; ++i) {
    bytes[front - kSizeBytes + i] =
        static_cast<std::uint8_t>(static_cast<std::uint32_t>(head.size) >> (24 - 8 * i));
  }
  std::ranges::copy(data, bytes.begin() + static_cast<std::ptrdiff_t>(front));
}

Result<ChunkView> decode_chunk(ByteView bytes) {
  if (auto shape = check_shape(shape_of<chunk_t>(), bytes); !shape) {
    return pass_on(shape, chunk_t::getTypeName());
  }
  ChunkView chunk{{}, bytes.subspan(kHeadBytes)};
  // The generated decoder is shown a chunk of no data.
  std::array<std::uint8_t, kHeadBytes> front;
  std::ranges::copy(bytes.first(kHeadBytes), front.begin());
  std::fill(front.end() - kSizeBytes, front.end(), std::uint8_t{0});
  if (chunk.head.decode(front.data(), 0, kHeadBytes) != int{kHeadBytes}) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{}: another type's fingerprint", chunk_t::getTypeName()));
  }
  chunk.head.size = static_cast<std::int32_t>(chunk.data.size());
  if (auto fields = check_fields(chunk.head); !fields) {
    return pass_on(fields, chunk_t::getTypeName());
  }
  return chunk;
}

}  // namespace voxatlas
