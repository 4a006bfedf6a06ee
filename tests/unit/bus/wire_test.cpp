// Every type against hostile bytes: a Result, never a crash, never memory the input does not
// justify.
#include "bus/wire.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "bus/random_messages.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

#define VOX_ALL_TYPES                                                                         \
  ack_t, camera_t, checkpoint_reply_t, checkpoint_request_t, chunk_t, counter_t, frame_t,     \
      model_reply_t, model_request_t, render_request_t, scan_delta_t, scan_t, status_t,       \
      tile_encoded_t, tile_raw_t, tile_reply_t, tile_request_t, tile_update_t, tiles_reply_t, \
      tiles_request_t

/// Bytes that the blobs, strings and lists of a message take: what its decoder allocates.
template <class T>
std::size_t encoded_size(const T& message) {
  return static_cast<std::size_t>(message.getEncodedSize());
}

TEMPLATE_TEST_CASE("a message comes back as it went, and its shape is the generated one's",
                   "[bus][oracle]", VOX_ALL_TYPES) {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  test::RandomMessages random(rng);
  for (int i = 0; i < 200; ++i) {
    const auto bytes = encode_message(random.make<TestType>());
    const auto back = decode_message<TestType>(bytes);
    if (!back) FAIL(back.error().message);
    REQUIRE(encode_message(*back) == bytes);
    REQUIRE(encoded_size(*back) == bytes.size());
  }
}

TEMPLATE_TEST_CASE("a message cut short anywhere, or longer than it is, is corrupt", "[bus]",
                   VOX_ALL_TYPES) {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  test::RandomMessages random(rng);
  auto bytes = encode_message(random.make<TestType>());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = decode_message<TestType>(ByteView(bytes).first(size));
    REQUIRE_FALSE(cut.has_value());
    REQUIRE(cut.error().code == ErrorCode::kCorrupt);
  }
  bytes.push_back(0);
  REQUIRE_FALSE(decode_message<TestType>(bytes).has_value());
}

TEMPLATE_TEST_CASE("hostile numbers anywhere in a message do no harm", "[bus]", VOX_ALL_TYPES) {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  test::RandomMessages random(rng);
  constexpr std::array<std::uint32_t, 6> kHostile{0,          1,          0x7fffffff,
                                                  0x80000000, 0xffffffff, 0xfffffff0};
  for (int run = 0; run < 3; ++run) {
    const auto good = encode_message(random.make<TestType>());
    for (std::size_t at = 8; at + 4 <= good.size(); ++at) {
      for (const auto value : kHostile) {
        auto bytes = good;
        for (std::size_t i = 0; i < 4; ++i) {
          bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
        }
        const auto back = decode_message<TestType>(bytes);
        if (!back) {
          REQUIRE(back.error().code == ErrorCode::kCorrupt);
        } else {
          REQUIRE(encode_message(*back) == bytes);
        }
      }
    }
  }
}

TEMPLATE_TEST_CASE("random bytes behind a type's fingerprint do no harm", "[bus]", VOX_ALL_TYPES) {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto fingerprint = encode_message(test::RandomMessages(rng).make<TestType>());
  for (int run = 0; run < 2000; ++run) {
    Bytes bytes(rng() % 300);
    for (auto& byte : bytes) byte = rng() % 3 == 0 ? static_cast<std::uint8_t>(rng()) : 0;
    std::copy_n(fingerprint.begin(), std::min<std::size_t>(8, bytes.size()), bytes.begin());
    const auto back = decode_message<TestType>(bytes);
    if (back) REQUIRE(encode_message(*back) == bytes);
  }
}

TEST_CASE("another type's fingerprint is corrupt, even where the shape is the same", "[bus]") {
  auto rng = test::engine();
  auto bytes = encode_message(test::RandomMessages(rng).make<tile_encoded_t>());
  bytes[3] ^= 1;
  const auto back = decode_message<tile_encoded_t>(bytes);
  REQUIRE_FALSE(back.has_value());
  REQUIRE(back.error().message.find("tile_encoded_t") != std::string::npos);
}

/// Whether a good message of type T, changed so, is refused.
template <class T, class Change>
bool refused(Change change) {
  auto rng = test::engine();
  auto message = test::RandomMessages(rng).make<T>();
  change(message);
  const auto back = decode_message<T>(encode_message(message));
  return !back.has_value() && back.error().code == ErrorCode::kCorrupt;
}

TEST_CASE("fields that contradict one another are corrupt", "[bus]") {
  CHECK(refused<ack_t>([](auto& m) { ++m.gaps; }));
  CHECK(refused<ack_t>([](auto& m) { m.committed = m.received + 1; }));
  CHECK(refused<ack_t>([](auto& m) { set_ranges(m, {{5, 5}}); }));
  CHECK(refused<chunk_t>([](auto& m) { m.index = m.count; }));
  CHECK(refused<chunk_t>([](auto& m) { m.base = m.seq + 1; }));
  CHECK(refused<chunk_t>([](auto& m) { m.offered = m.seq; }));
  CHECK(refused<chunk_t>([](auto& m) { m.count = -1; }));
  CHECK(refused<frame_t>([](auto& m) { m.error = "no picture", m.size = 1, m.data = {1}; }));
  CHECK(
      refused<frame_t>([](auto& m) { m.depth_format = 0, m.depth_size = 1, m.depth_data = {1}; }));
  CHECK(refused<scan_t>([](auto& m) { ++m.count; }));
  CHECK(refused<scan_t>([](auto& m) { m.part = m.parts; }));
  CHECK(refused<scan_t>([](auto& m) { m.parts = 65; }));
  CHECK(refused<scan_t>([](auto& m) { m.source.clear(); }));
  CHECK(refused<scan_t>([](auto& m) { m.source.assign(65, 's'); }));
  CHECK(refused<scan_t>([](auto& m) { m.session = -1; }));
  CHECK(refused<scan_delta_t>([](auto& m) { m.shard = m.shards; }));
  CHECK(refused<scan_delta_t>([](auto& m) { ++m.tiles; }));
  CHECK(refused<scan_delta_t>([](auto& m) { m.tiles = 2, m.size = 24, m.data = Bytes(24); }));
  CHECK(refused<tile_reply_t>([](auto& m) { m.total = m.offset + m.size - 1; }));
  CHECK(refused<tile_update_t>([](auto& m) { m.content = 0, m.size = 1, m.payload = {1}; }));
  CHECK(refused<tiles_reply_t>([](auto& m) { ++m.tiles; }));
}

}  // namespace
}  // namespace voxatlas
