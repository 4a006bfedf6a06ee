#include "base/sha256.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TEST_CASE("sha256 gives the values of FIPS 180-2, whole and in pieces", "[base]") {
  const auto expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  REQUIRE(to_hex(sha256(as_bytes("abc"))) == expected);
  Sha256 pieces;
  pieces.update(as_bytes("a"));
  pieces.update(as_bytes("bc"));
  REQUIRE(to_hex(pieces.finish()) == expected);
}

}  // namespace
}  // namespace voxatlas
