#include "atlas/tile_mirror.hpp"

#include <catch2/catch.hpp>

#include "codec/tile_codec.hpp"
#include "support/engine.hpp"
#include "unit/atlas/atlas_world.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kTiles = 40;

/// A store that remembers nothing but its tiles, and a wire that loses, doubles and overtakes.
struct LossyWire {
  explicit LossyWire(const TileBox& box = {}, int depth = kDepth)
      : world(test::engine()(), kTiles), mirror(box, depth, SensorModel::standard()) {}

  /// One scan happens; its changes are heard, or not, or later.
  void scan(std::uint32_t lost_of_100) {
    for (auto& change : world.add(world.next_scan("car", 1))) {
      if (world.random.below(100) < lost_of_100) continue;
      late.push_back(std::move(change));
      if (world.random.below(10) == 0) late.push_back(late.back());
    }
    while (late.size() > world.random.below(4)) {
      const auto at = late.begin() + world.random.below(static_cast<std::uint32_t>(late.size()));
      hear(*at);
      late.erase(at);
    }
  }

  void hear(const TileChange& change) {
    const bool large = world.random.below(20) == 0;  // As if it did not fit a datagram.
    mirror.on_change(change.key, change.version,
                     large ? std::nullopt : std::optional<ByteView>(change.delta));
  }

  void list() {
    for (const auto& [key, tile] : world.tiles) mirror.on_listed(key, tile.version);
  }

  void fetch(std::size_t limit) {
    for (const TileKey key : mirror.to_fetch(limit)) {
      const auto& tile = world.tiles.at(key);
      REQUIRE(mirror.on_tile(key, tile.version, encode_tile(tile.tree, {})).has_value());
    }
  }

  test::World world;
  TileMirror mirror;
  std::vector<TileChange> late;
};

/// What a mirror knows against what it should know; the first difference, or nothing.
std::string difference(const TileMirror& mirror, const test::World& world, const TileBox& box,
                       int depth) {
  std::string first;
  std::size_t count = 0;
  mirror.for_each([&](TileKey key, std::uint64_t version, const TileTree& tree) {
    const auto expected = world.tiles.find(key);
    ++count;
    if (!first.empty()) return;
    if (!box.holds(key)) first = "a tile outside of the box";
    if (expected == world.tiles.end()) first = "a tile that never was";
    if (!first.empty()) return;
    if (expected->second.version != version) first = "a version";
    if (!(tree == cut_tile(expected->second.tree, depth))) first = "a tree";
  });
  const auto wanted =
      std::ranges::count_if(world.tiles, [&](const auto& tile) { return box.holds(tile.first); });
  if (first.empty() && count != static_cast<std::size_t>(wanted)) first = "how many there are";
  return first;
}

TEST_CASE("a mirror that hears everything in order fetches nothing", "[atlas]") {
  LossyWire wire;
  for (int i = 0; i < 60; ++i) {
    for (const auto& change : wire.world.add(wire.world.next_scan("car", 1))) {
      wire.mirror.on_change(change.key, change.version, ByteView(change.delta));
    }
  }
  REQUIRE(wire.mirror.behind() == 0);
  REQUIRE(wire.mirror.counters().fetched == 0);
  REQUIRE(difference(wire.mirror, wire.world, {}, kDepth) == "");
}

TEST_CASE("whatever was lost, doubled or overtaken, a list and fetching make a mirror equal",
          "[atlas][oracle]") {
  for (int run = 0; run < 12; ++run) {
    LossyWire wire;
    INFO("VOX_SEED=" << test::seed() << " run " << run);
    const std::uint32_t lost = run % 4 == 0 ? 60 : 5;
    for (int i = 0; i < 60; ++i) {
      wire.scan(lost);
      if (wire.world.random.below(5) == 0) wire.fetch(1 + wire.world.random.below(3));
    }
    // Quiet: what is on its way arrives, in any order.
    for (const auto& change : wire.late) wire.hear(change);
    wire.list();
    wire.fetch(SIZE_MAX);
    REQUIRE(wire.mirror.behind() == 0);
    REQUIRE(wire.mirror.counters().applied > 0);
    REQUIRE(wire.mirror.counters().fetched > 0);
    REQUIRE(difference(wire.mirror, wire.world, {}, kDepth) == "");
  }
}

TEST_CASE("a late joiner is equal after one list, and goes on by deltas alone", "[atlas]") {
  LossyWire wire;
  for (int i = 0; i < 20; ++i) wire.world.add(wire.world.next_scan("car", 1));
  wire.list();
  // Between list and fetch the world goes on, and the changes are heard before the tiles come.
  for (const auto& change : wire.world.add(wire.world.next_scan("car", 1))) wire.hear(change);
  wire.fetch(SIZE_MAX);
  REQUIRE(wire.mirror.behind() == 0);
  const auto fetched = wire.mirror.counters().fetched;
  for (int i = 0; i < 20; ++i) {
    for (const auto& change : wire.world.add(wire.world.next_scan("car", 1))) {
      wire.mirror.on_change(change.key, change.version, ByteView(change.delta));
    }
  }
  REQUIRE(wire.mirror.counters().fetched == fetched);
  REQUIRE(difference(wire.mirror, wire.world, {}, kDepth) == "");
}

TEST_CASE("a mirror of a box at a depth knows its tiles at that depth, and no others",
          "[atlas][oracle]") {
  const int depth = GENERATE(0, 4, 6, 7);
  const TileBox box{{1, 0, 0}, {2, 3, 1}};
  LossyWire wire(box, depth);
  CAPTURE(depth);
  for (int i = 0; i < 40; ++i) wire.scan(5);
  for (const auto& change : wire.late) wire.hear(change);
  wire.list();
  wire.fetch(SIZE_MAX);
  REQUIRE(wire.mirror.behind() == 0);
  REQUIRE(wire.mirror.tiles() > 0);
  REQUIRE(difference(wire.mirror, wire.world, box, depth) == "");
}

TEST_CASE("a tile that does not decode stays behind, and is asked for again", "[atlas]") {
  LossyWire wire;
  const TileKey key = test::key(7);
  wire.mirror.on_listed(key, 3);
  const Bytes nonsense(50, 1);
  REQUIRE(wire.mirror.on_tile(key, 3, nonsense).error().code == ErrorCode::kCorrupt);
  REQUIRE(wire.mirror.to_fetch(9) == std::vector<TileKey>{key});
  REQUIRE(wire.mirror.on_tile(key, 3, encode_tile(TileTree(), {})).has_value());
  REQUIRE(wire.mirror.behind() == 0);
  wire.mirror.on_change(key, 4, ByteView(nonsense));
  REQUIRE(wire.mirror.to_fetch(9) == std::vector<TileKey>{key});
}

TEST_CASE("deltas that wait for one that never comes do not pile up", "[atlas]") {
  LossyWire wire;
  const TileKey key = test::key(7);
  const Bytes delta = test::delta_bytes({});
  for (std::uint64_t version = 2; version < 2000; ++version) {
    wire.mirror.on_change(key, version, ByteView(delta));
  }
  REQUIRE(wire.mirror.on_tile(key, 1990, encode_tile(TileTree(), {})).has_value());
  REQUIRE(wire.mirror.behind() == 0);  // Its last deltas were at hand.
}

}  // namespace
}  // namespace voxatlas
