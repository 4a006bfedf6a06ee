#include "compress/open_tiles.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

/// Nothing, or one message.
std::int64_t done_of(const std::vector<OpenTiles::Raw>& done, std::int64_t session) {
  for (const auto& raw : done) {
    if (raw.session == session) return raw.number;
  }
  return -1;
}

TEST_CASE("a tile is done with when the store has its result, and not before", "[compress]") {
  OpenTiles open;
  open.answered({7, 0}, {0, 100});
  open.answered({7, 1}, {0, 101});
  open.answered({8, 0}, {1, 50});
  REQUIRE(open.take_done([](std::size_t) { return std::int64_t{50}; }).empty());
  const auto done = open.take_done([](std::size_t shard) { return shard == 0 ? 101 : 51; });
  REQUIRE(done.size() == 2);
  REQUIRE(done_of(done, 7) == 0);
  REQUIRE(done_of(done, 8) == 0);
  REQUIRE(open.size() == 1);
}

TEST_CASE("a dropped tile waits for those before it", "[compress]") {
  OpenTiles open;
  open.answered({7, 0}, {0, 3});
  open.dropped({7, 1});
  open.dropped({7, 2});
  open.answered({7, 3}, {0, 4});
  REQUIRE(open.take_done([](std::size_t) { return std::int64_t{3}; }).empty());
  REQUIRE(done_of(open.take_done([](std::size_t) { return std::int64_t{4}; }), 7) == 2);
  REQUIRE(done_of(open.take_done([](std::size_t) { return std::int64_t{5}; }), 7) == 3);
  REQUIRE(open.size() == 0);
}

}  // namespace
}  // namespace voxatlas
