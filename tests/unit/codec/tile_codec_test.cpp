#include "codec/tile_codec.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "base/crc32c.hpp"
#include "codec/node_stream.hpp"
#include "codec/zstd_frame.hpp"
#include "support/engine.hpp"
#include "unit/octree/random_octree.hpp"

namespace voxatlas {
namespace {

TileTree random_tree(test::RandomOctree& random) {
  TileTree tree;
  for (auto count = random.below(60); count > 0; --count) tree.set(random.cell(), random.state());
  for (auto count = random.below(4); count > 0; --count) tree.apply(random.delta(), random.model());
  return tree;
}

/// A header as FORMAT.md states it, with a right checksum, before any content.
Bytes sealed(std::uint8_t version, std::uint8_t codec, std::uint32_t size, ByteView content) {
  Bytes tile;
  ByteWriter out(tile);
  for (const char letter : {'V', 'X', 'T', 'L'}) out.put(letter);
  out.put(version);
  out.put(codec);
  out.put(size);
  const auto sum = crc32c(content, crc32c(tile));
  out.put(sum);
  out.put_bytes(content);
  return tile;
}

Bytes frame_of(ByteView content) {
  Bytes frame;
  zstd_compress(content, 1, frame);
  return frame;
}

TEST_CASE("a tile survives both codecs, at any level", "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 100; ++i) {
    const auto tree = random_tree(random);
    const auto codec = i % 2 == 0 ? TileCodec::kFast : TileCodec::kDense;
    const auto bytes = encode_tile(tree, {codec, static_cast<int>(random.below(20))});
    REQUIRE(codec_of(bytes).value() == codec);
    REQUIRE(decode_tile(bytes).value() == tree);
    REQUIRE(bytes.size() <= encode_nodes(tree).size() + 64);
  }
}

TEST_CASE("every single flipped bit and every cut of a tile is detected", "[codec]") {
  test::RandomOctree random(test::seed());
  const auto bytes = encode_tile(random_tree(random), {});
  REQUIRE(bytes.size() > 100);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto flipped = bytes;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1u << bit % 8);
    REQUIRE_FALSE(decode_tile(flipped).has_value());
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    REQUIRE(decode_tile(ByteView(bytes).first(size)).error().code == ErrorCode::kCorrupt);
  }
  auto longer = bytes;
  longer.push_back(0);
  REQUIRE(decode_tile(longer).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("a header that lies is refused although its checksum is right", "[codec]") {
  const Bytes nodes{0};
  REQUIRE(decode_tile(sealed(1, 1, 1, frame_of(nodes))).value().empty());
  REQUIRE(decode_tile(sealed(2, 1, 1, frame_of(nodes))).error().code == ErrorCode::kInvalid);
  REQUIRE(decode_tile(sealed(0, 1, 1, frame_of(nodes))).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 0, 1, frame_of(nodes))).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 3, 1, frame_of(nodes))).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 1, 2, frame_of(nodes))).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 1, ~0u, frame_of(nodes))).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 1, 1, nodes)).error().code == ErrorCode::kCorrupt);
  REQUIRE(codec_of(Bytes{}).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("a frame that would unfold beyond one tile is refused before it does", "[codec]") {
  const Bytes bomb(kMaxNodeBytes + 1);
  const auto frame = frame_of(bomb);
  REQUIRE(frame.size() < 20'000);
  const auto stated = static_cast<std::uint32_t>(bomb.size());
  REQUIRE(decode_tile(sealed(1, 1, stated, frame)).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_tile(sealed(1, 1, 100, frame)).error().code == ErrorCode::kCorrupt);
}

/// The tile of the golden files, a bit of everything.
TileTree golden_tree() {
  const auto model = SensorModel::standard();
  TileTree tree;
  tree.set(CellKey{1, 3}, {-3000, {}});
  for (std::uint32_t code = 0; code < 4096; code += 37) tree.miss(CellKey{4, code}, model);
  for (std::uint32_t code = 1000; code < 60'000; code += 71) {
    const auto shade = static_cast<std::uint8_t>(code);
    tree.hit(CellKey{kDepth, code}, model);
    if (code % 2 == 0) tree.hit(CellKey{kDepth, code}, model, Rgb{shade, 90, 17});
  }
  tree.hit(CellKey{6, 200'000}, model, Rgb{255, 255, 255});
  return tree;
}

TEST_CASE("tiles that version 1 wrote are read for ever", "[codec][golden]") {
  for (const std::string name : {"fast_v1.tile", "dense_v1.tile"}) {
    const auto path = std::string(VOX_TEST_DATA "/codec/") + name;
    INFO(path);
    std::ifstream file(path, std::ios::binary);
    const Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const auto tree = decode_tile(bytes);
    REQUIRE(tree.has_value());
    REQUIRE(*tree == golden_tree());
  }
}

}  // namespace
}  // namespace voxatlas
