#include "store/store_format.hpp"

#include <catch2/catch.hpp>

#include "base/crc32c.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("row keys sort as their shards and numbers do", "[store][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int i = 0; i < 10'000; ++i) {
    const auto near = [&] { return rng() >> rng() % 64; };
    const std::pair<ShardId, std::uint64_t> a{static_cast<ShardId>(near()), near()};
    const std::pair<ShardId, std::uint64_t> b{static_cast<ShardId>(near()), near()};
    REQUIRE((row_key(a.first, a.second) < row_key(b.first, b.second)) == (a < b));
    REQUIRE(row_number(row_key(a.first, a.second)).value() == a.second);
  }
}

TEST_CASE("a tile's row is, to the byte, what FORMAT.md says", "[store][golden]") {
  const StoredTile tile{TileKey::from_morton(0x0102030405060708).value(), 0x11, {0xaa, 0xbb}};
  const auto key = row_key(0x01020304, tile.key.morton());
  REQUIRE(key == std::string("\x01\x02\x03\x04\x01\x02\x03\x04\x05\x06\x07\x08", 12));
  const std::string body("\x11\0\0\0\0\0\0\0\xaa\xbb", 10);
  const auto sum = crc32c(as_bytes(key + body));
  const std::string expected = std::string(reinterpret_cast<const char*>(&sum), 4) + body;
  REQUIRE(seal_tile(key, tile) == expected);
}

TEST_CASE("every flipped bit and every cut of a row is detected", "[store]") {
  const StoredTile tile{TileKey::from_morton(99).value(), 5, {1, 2, 3, 4, 5}};
  const auto key = row_key(3, tile.key.morton());
  const auto sealed = seal_tile(key, tile);
  REQUIRE(unseal_tile(key, sealed).value().bytes == tile.bytes);
  for (std::size_t bit = 0; bit < sealed.size() * 8; ++bit) {
    auto flipped = sealed;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
    REQUIRE(unseal_tile(key, flipped).error().code == ErrorCode::kCorrupt);
  }
  for (std::size_t size = 0; size < sealed.size(); ++size) {
    REQUIRE(unseal_tile(key, sealed.substr(0, size)).error().code == ErrorCode::kCorrupt);
  }
  REQUIRE(unseal_tile(row_key(3, 98), sealed).error().code == ErrorCode::kCorrupt);
  REQUIRE(unseal_tile(row_key(4, 99), sealed).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("marks come back as they went, and no others do", "[store]") {
  const std::vector<Mark> marks{{"car", -5, 12}, {"", 7, -1}, {std::string(300, 'x'), 0, 1}};
  const auto bytes = encode_marks(marks);
  REQUIRE(decode_marks(bytes).value() == marks);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    REQUIRE_FALSE(decode_marks(ByteView(bytes).first(size)).has_value());
  }
  auto longer = bytes;
  longer.push_back(0);
  REQUIRE_FALSE(decode_marks(longer).has_value());
}

}  // namespace
}  // namespace voxatlas
