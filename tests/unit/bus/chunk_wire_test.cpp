#include "bus/chunk_wire.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

Bytes random_bytes(std::mt19937_64& rng, std::size_t count) {
  Bytes bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
  return bytes;
}

/// One whose fields agree with one another, and any number in each.
chunk_t random_chunk(std::mt19937_64& rng, std::size_t size) {
  const auto below = [&](std::int64_t end) {
    return static_cast<std::int64_t>(rng() % static_cast<std::uint64_t>(end));
  };
  chunk_t chunk{};
  chunk.session = static_cast<std::int64_t>(rng());
  chunk.base = below(1'000'000);
  chunk.index = static_cast<std::int32_t>(below(1000));
  chunk.count = static_cast<std::int32_t>(chunk.index + 1 + below(1000));
  chunk.seq = chunk.base + chunk.index + below(1'000'000);
  chunk.offered = chunk.seq + 1 + below(1'000'000);
  chunk.message = below(1'000'000);
  chunk.kind = static_cast<std::int16_t>(rng());
  chunk.crc = static_cast<std::int32_t>(rng());
  chunk.data = random_bytes(rng, size);
  chunk.size = static_cast<std::int32_t>(size);
  return chunk;
}

chunk_t head_of(const chunk_t& chunk) {
  chunk_t head = chunk;
  head.data.clear();
  return head;
}

chunk_t joined(const ChunkView& view) {
  chunk_t chunk = view.head;
  chunk.data.assign(view.data.begin(), view.data.end());
  return chunk;
}

TEST_CASE("a chunk whose data stands apart is written and read as the generated code does it",
          "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  Bytes encoded;
  for (const std::size_t size : {59'000, 0, 1, 255, 256, 1'300}) {
    const chunk_t chunk = random_chunk(rng, size);
    encode_chunk(head_of(chunk), chunk.data, encoded);
    REQUIRE(encoded == encode_message(chunk));
    const auto decoded = decode_chunk(encoded);
    REQUIRE(decoded.has_value());
    REQUIRE(decoded->head.data.empty());
    REQUIRE(decoded->data.data() + size == encoded.data() + encoded.size());  // Not a copy.
    REQUIRE(encode_message(joined(*decoded)) == encoded);
  }
}

TEST_CASE("a damaged chunk is refused where the generated code's is", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const Bytes good = encode_message(random_chunk(rng, 300));
  const auto require_like_generated = [](const Bytes& bytes) {
    const auto ours = decode_chunk(bytes);
    const auto whole = decode_message<chunk_t>(bytes);
    REQUIRE(ours.has_value() == whole.has_value());
    if (ours) REQUIRE(encode_message(joined(*ours)) == encode_message(*whole));
    if (!ours) REQUIRE(ours.error().message == whole.error().message);
  };
  for (std::size_t size = 0; size < good.size(); ++size) {
    require_like_generated({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)});
  }
  for (std::size_t bit = 0; bit < 8 * 80; ++bit) {  // The head and a little of the data.
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1u << bit % 8);
    require_like_generated(bad);
  }
}

}  // namespace
}  // namespace voxatlas
