#include "atlas/rested_tiles.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

using Clock = RestedTiles::Clock;

TileKey key(std::uint64_t code) { return TileKey::from_morton(code).value(); }
Clock::time_point at(int second) { return Clock::time_point(std::chrono::seconds(second)); }

std::vector<std::uint64_t> codes(const std::vector<RestedTiles::Tile>& tiles) {
  std::vector<std::uint64_t> list;
  for (const auto& tile : tiles) list.push_back(tile.key.morton());
  return list;
}

TEST_CASE("tiles rest in the order they came, and come anew when they change", "[atlas]") {
  RestedTiles rested;
  for (int i = 1; i <= 5; ++i) rested.add(key(static_cast<std::uint64_t>(i)), 1, at(i));
  REQUIRE(codes(rested.oldest(10, at(3))) == std::vector<std::uint64_t>{1, 2, 3});
  rested.add(key(1), 2, at(6));
  rested.remove(key(3));
  rested.remove(key(99));
  REQUIRE(codes(rested.oldest(3, at(9))) == std::vector<std::uint64_t>{2, 4, 5});
  REQUIRE(codes(rested.oldest(9, at(9))) == std::vector<std::uint64_t>{2, 4, 5, 1});
  REQUIRE(rested.oldest(9, at(9)).back().version == 2);
}

TEST_CASE("beyond the limit the oldest are forgotten, and it says so", "[atlas]") {
  RestedTiles rested;
  for (std::uint64_t i = 0; i < RestedTiles::kLimit; ++i) rested.add(key(i), 1, at(0));
  REQUIRE_FALSE(rested.overflowed());
  rested.add(key(RestedTiles::kLimit), 1, at(0));
  REQUIRE(rested.overflowed());
  REQUIRE(rested.size() == RestedTiles::kLimit);
  REQUIRE(codes(rested.oldest(1, at(0))) == std::vector<std::uint64_t>{1});
}

}  // namespace
}  // namespace voxatlas
