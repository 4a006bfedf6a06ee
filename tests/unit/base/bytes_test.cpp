#include "base/bytes.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("what a ByteWriter writes a ByteReader reads", "[base]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  for (int round = 0; round < 1000; ++round) {
    const std::uint64_t any = rng() >> (rng() % 64);  // Every length of varint.
    Bytes bytes;
    ByteWriter writer(bytes);
    writer.put_varint(any);
    writer.put(static_cast<std::int16_t>(any));
    writer.put(1.5);
    writer.put_string("tile");

    ByteReader reader(bytes);
    REQUIRE(reader.get_varint() == any);
    REQUIRE(reader.get<std::int16_t>() == static_cast<std::int16_t>(any));
    REQUIRE(reader.get<double>() == 1.5);
    REQUIRE(reader.get_string() == "tile");
    REQUIRE(reader.at_end());
  }
}

TEST_CASE("a ByteReader fails for good at the first byte that is missing", "[base]") {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put_varint(300);
  writer.put(std::uint32_t{7});
  writer.put_string("abc");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ByteReader reader(ByteView(bytes).first(length));
    reader.get_varint();
    reader.get<std::uint32_t>();
    reader.get_string();
    REQUIRE_FALSE(reader.ok());
    REQUIRE(reader.get<std::uint8_t>() == 0);
    REQUIRE(reader.remaining() == 0);
  }
}

TEST_CASE("a varint of more than 64 bits is refused", "[base]") {
  const Bytes eleven(11, 0xff);
  ByteReader reader(eleven);
  reader.get_varint();
  REQUIRE_FALSE(reader.ok());

  Bytes largest;
  ByteWriter(largest).put_varint(std::numeric_limits<std::uint64_t>::max());
  ByteReader again(largest);
  REQUIRE(again.get_varint() == std::numeric_limits<std::uint64_t>::max());
  REQUIRE(again.at_end());
}

TEST_CASE("a length that lies does not allocate", "[base]") {
  Bytes bytes;
  ByteWriter(bytes).put_varint(std::uint64_t{1} << 60);
  ByteReader reader(bytes);
  REQUIRE(reader.get_string().empty());
  REQUIRE_FALSE(reader.ok());
}

}  // namespace
}  // namespace voxatlas
