#include "atlas/journal_record.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }

TEST_CASE("a journal record is, to the byte, what FORMAT.md says", "[atlas][golden]") {
  const Bytes delta{0xaa, 0xbb};
  const JournalRecord record{"car", -2, 5, {{key(0x0102), 300, delta}}};
  const Bytes expected{0x01, 0x03, 'c',  'a',  'r',  0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                       0xff, 0x05, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x02, 0x01,
                       0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xac, 0x02, 0x02, 0xaa, 0xbb};
  REQUIRE(encode_record(record) == expected);
  const auto back = decode_record(expected).value();
  REQUIRE(back.source == "car");
  REQUIRE(back.session == -2);
  REQUIRE(back.seq == 5);
  REQUIRE(back.deltas.size() == 1);
  REQUIRE(back.deltas[0].key == key(0x0102));
  REQUIRE(back.deltas[0].version == 300);
  REQUIRE(Bytes(back.deltas[0].delta.begin(), back.deltas[0].delta.end()) == delta);
}

TEST_CASE("a record that is cut, too long, of another kind or off the grid is refused", "[atlas]") {
  const Bytes delta{1, 2, 3};
  const auto bytes = encode_record({"s", 1, 2, {{key(7), 1, delta}, {key(8), 1, delta}}});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    REQUIRE(decode_record(ByteView(bytes).first(size)).error().code == ErrorCode::kCorrupt);
  }
  auto longer = bytes;
  longer.push_back(0);
  REQUIRE(decode_record(longer).error().code == ErrorCode::kCorrupt);
  auto kind = bytes;
  kind[0] = 2;
  REQUIRE(decode_record(kind).error().code == ErrorCode::kCorrupt);
  auto off = bytes;
  off[20 + 7] = 0xff;  // The high byte of the first key.
  REQUIRE(decode_record(off).error().code == ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace voxatlas
