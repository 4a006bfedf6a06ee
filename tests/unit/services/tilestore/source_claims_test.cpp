#include "tilestore/source_claims.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

constexpr auto kLease = SourceClaims::kLeaseUs;

TEST_CASE("a source is its first claimant's for as long as he goes on claiming", "[tilestore]") {
  SourceClaims claims;
  REQUIRE(claims.claim("car", 1, 0) == 1);
  for (std::int64_t now = 0; now < 10 * kLease; now += kLease / 4) {
    REQUIRE(claims.claim("car", 1, now) == 1);
    REQUIRE(claims.claim("car", 2, now + 1) == 1);
    REQUIRE(claims.holder("car", now + 1) == 1);
  }
  REQUIRE(claims.holder("van", 0) == 0);
  REQUIRE(claims.claim("van", 2, 0) == 2);
}

TEST_CASE("a claim that is not made again lapses, and the source is the next one's",
          "[tilestore]") {
  SourceClaims claims;
  REQUIRE(claims.claim("car", 1, 0) == 1);
  REQUIRE(claims.claim("car", 2, kLease - 1) == 1);
  REQUIRE(claims.claim("car", 2, kLease) == 2);
  REQUIRE(claims.claim("car", 1, kLease) == 2);
  claims.give_back("car", 1);  // Not his.
  REQUIRE(claims.holder("car", kLease) == 2);
  claims.give_back("car", 2);
  REQUIRE(claims.holder("car", kLease) == 0);
}

TEST_CASE("a flood of claims is bounded, and those that lapse make room", "[tilestore]") {
  SourceClaims claims;
  for (std::size_t i = 0; i < SourceClaims::kMaxClaims; ++i) {
    REQUIRE(claims.claim(fmt::format("source {}", i), 1, 0) == 1);
  }
  REQUIRE(claims.claim("one more", 1, kLease - 1) == 0);
  REQUIRE(claims.claim("source 5", 1, kLease - 1) == 1);
  REQUIRE(claims.claim("one more", 1, kLease) == 1);
}

}  // namespace
}  // namespace voxatlas
