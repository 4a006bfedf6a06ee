#include "codec/tile_codec.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <random>

#include "base/crc32c.hpp"
#include "codec/node_stream.hpp"
#include "codec/zstd_frame.hpp"
#include "octree/brick_mask.hpp"
#include "octree/tile_hash.hpp"
#include "unit/codec/codec_trees.hpp"

namespace voxatlas {
namespace {

using test::golden_tree;
using test::random_tree;

const CodecOptions kAllCodecs[] = {
    {TileCodec::kFast}, {TileCodec::kDense}, {TileCodec::kLossy, 0, {6, 5}}};

/// A header as FORMAT.md states it, with a right checksum, before any content. `middle`: what
/// version 1 has between codec and checksum.
Bytes sealed(std::uint8_t version, std::uint8_t codec, ByteView middle, ByteView content) {
  Bytes tile;
  ByteWriter out(tile);
  for (const char letter : {'V', 'X', 'T', 'L'}) out.put(letter);
  out.put(version);
  out.put(codec);
  out.put_bytes(middle);
  const auto sum = crc32c(content, crc32c(tile));
  out.put(sum);
  out.put_bytes(content);
  return tile;
}

Bytes sealed_v1(std::uint8_t codec, std::uint32_t size, ByteView content) {
  Bytes middle;
  ByteWriter(middle).put(size);
  return sealed(1, codec, middle, content);
}

Bytes frame_of(ByteView content) {
  Bytes frame;
  zstd_compress(content, 1, frame);
  return frame;
}

ErrorCode error_of(const Bytes& bytes) { return decode_tile(bytes).error().code; }

TEST_CASE("a tile survives the exact codecs, at any level, and says which it is",
          "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 100; ++i) {
    const auto tree = random_tree(random);
    const auto codec = i % 2 == 0 ? TileCodec::kFast : TileCodec::kDense;
    const auto bytes = encode_tile(tree, {codec, static_cast<int>(random.below(20))});
    REQUIRE(codec_of(bytes).value() == codec);
    REQUIRE(decode_tile(bytes).value() == tree);
    REQUIRE(quantization_of(bytes).error().code == ErrorCode::kInvalid);
    const auto counts = tree.counts();
    const auto raw = 8 * (counts.leaves + counts.inner) + counts.coloured_leaves * 8;
    REQUIRE(bytes.size() <= raw + 64);
  }
}

TEST_CASE("a lossy tile is its quantised tile, exactly, and says how", "[codec][oracle]") {
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 40; ++i) {
    const auto tree = test::scanned_tree(random);
    const Quantization how{1 + i % 16, i % 9};
    const auto bytes = encode_tile(tree, {TileCodec::kLossy, 0, how});
    REQUIRE(codec_of(bytes).value() == TileCodec::kLossy);
    REQUIRE(quantization_of(bytes).value() == how);
    REQUIRE(decode_tile(bytes).value() == quantize(tree, how));
  }
}

/// Tiles that no codec likes: noise, and little that stands far apart.
std::vector<TileTree> unkind_trees(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<TileTree> trees;
  trees.reserve(100);  // References stay good.
  const auto state = [&](bool coloured) {
    CellState any{static_cast<LogOdds>(rng()), {}};
    if (any.log_odds < 0 || !coloured) return any;
    for (auto n = 1 + rng() % 16; n > 0; --n) {
      any.colour.add(Rgb{static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng()),
                         static_cast<std::uint8_t>(rng())});
    }
    return any;
  };
  for (std::uint32_t depth = 0; depth <= kDepth; ++depth) {  // A single leaf.
    const CellKey cell{static_cast<std::uint8_t>(depth), (1u << 3 * depth) - 1};
    trees.emplace_back().set(cell, {-1661, {}});
    trees.emplace_back().set(cell, state(true));
  }
  for (int i = 0; i < 20; ++i) trees.emplace_back().set({0, 0}, state(true));
  for (const bool coloured : {false, true}) {
    auto& dense = trees.emplace_back();  // Bricks of nothing but noise.
    for (std::uint32_t code = 0; code < 60 * kBrickVoxels; ++code) {
      dense.set({kDepth, code * 7}, state(coloured));
    }
    auto& lonely = trees.emplace_back();  // A voxel of each brick.
    auto& bricks = trees.emplace_back();  // Bricks of one value, here and there.
    auto& cells = trees.emplace_back();   // Cells of any size.
    for (std::uint32_t brick = 0; brick < kBricks; ++brick) {
      const auto voxel = static_cast<std::uint32_t>(rng() % kBrickVoxels);
      lonely.set({kDepth, brick * kBrickVoxels + voxel}, state(coloured));
      if (rng() % 3 == 0) bricks.set({kBrickDepth, brick}, state(coloured));
      const auto depth = static_cast<std::uint32_t>(rng() % 8);
      if (brick % 8 != 0) continue;
      cells.set(
          {static_cast<std::uint8_t>(depth), static_cast<std::uint32_t>(rng() % (1u << 3 * depth))},
          state(coloured));
    }
  }
  return trees;
}

TEST_CASE("no tile is larger than the paper's raw nodes and 64 bytes", "[codec]") {
  INFO("VOX_SEED=" << test::seed());
  const auto trees = unkind_trees(test::seed());
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const auto counts = trees[i].counts();
    // A colour has three bytes there, an exact one seven.
    const auto raw = 8 * (counts.leaves + counts.inner) + 4 * counts.coloured_leaves;
    for (const auto& options : kAllCodecs) {
      CAPTURE(i, counts.leaves, counts.coloured_leaves, static_cast<int>(options.codec));
      const auto bytes = encode_tile(trees[i], options);
      REQUIRE(bytes.size() <= raw + 64);
      const bool lossy = codec_of(bytes).value() == TileCodec::kLossy;
      if (!lossy) REQUIRE(decode_tile(bytes).value() == trees[i]);
    }
  }
}

TEST_CASE("an empty tile has an encoding in every codec", "[codec]") {
  for (const auto& options : kAllCodecs) {
    const auto bytes = encode_tile(TileTree{}, options);
    REQUIRE(decode_tile(bytes).value().empty());
    REQUIRE(decode_tile_to_depth(bytes, 3).value().empty());
    REQUIRE(bytes.size() < 64);
  }
}

TEST_CASE("every single flipped bit and every cut of a tile is detected", "[codec]") {
  test::RandomOctree random(test::seed());
  TileTree tree;
  for (int i = 0; i < 20; ++i) tree.set(random.cell(), random.state());
  for (const auto& options : kAllCodecs) {
    const auto bytes = encode_tile(tree, options);
    REQUIRE(bytes.size() > 50);
    for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
      auto flipped = bytes;
      flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1u << bit % 8);
      REQUIRE_FALSE(decode_tile(flipped).has_value());
      REQUIRE_FALSE(decode_tile_to_depth(flipped, 2).has_value());
    }
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      REQUIRE(decode_tile(ByteView(bytes).first(size)).error().code == ErrorCode::kCorrupt);
    }
    auto longer = bytes;
    longer.push_back(0);
    REQUIRE(error_of(longer) == ErrorCode::kCorrupt);
  }
}

TEST_CASE("a header that lies is refused although its checksum is right", "[codec]") {
  const Bytes nodes{0};
  REQUIRE(decode_tile(sealed_v1(1, 1, frame_of(nodes))).value().empty());
  REQUIRE(error_of(sealed(3, 1, {}, {})) == ErrorCode::kInvalid);
  REQUIRE(error_of(sealed(0, 1, {}, {})) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed(2, 0, {}, {})) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed(2, 4, {}, {})) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed(2, 1, {}, nodes)) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed(2, 3, {}, nodes)) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(0, 1, frame_of(nodes))) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(3, 1, frame_of(nodes))) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(1, 2, frame_of(nodes))) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(1, ~0u, frame_of(nodes))) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(1, 1, nodes)) == ErrorCode::kCorrupt);
  REQUIRE(codec_of(Bytes{}).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("a frame that would unfold beyond one tile is refused before it does", "[codec]") {
  const Bytes bomb(kMaxNodeBytes + 1);
  const auto frame = frame_of(bomb);
  REQUIRE(frame.size() < 20'000);
  const auto stated = static_cast<std::uint32_t>(bomb.size());
  REQUIRE(error_of(sealed_v1(1, stated, frame)) == ErrorCode::kCorrupt);
  REQUIRE(error_of(sealed_v1(1, 100, frame)) == ErrorCode::kCorrupt);
  Bytes fast;
  ByteWriter out(fast);
  for (const std::uint64_t number : {std::uint64_t{1} << 40, std::uint64_t{1}, std::uint64_t{0}}) {
    out.put_varint(number);
  }
  REQUIRE(error_of(sealed(2, 1, {}, fast)) == ErrorCode::kCorrupt);
}

std::string golden_path(const std::string& name) { return VOX_TEST_DATA "/codec/" + name; }

Bytes read_golden(const std::string& name) {
  INFO(name);
  std::ifstream file(golden_path(name), std::ios::binary);
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST_CASE("tiles that version 1 wrote are read for ever", "[codec][golden]") {
  for (const std::string name : {"fast_v1.tile", "dense_v1.tile"}) {
    const auto bytes = read_golden(name);
    REQUIRE(decode_tile(bytes).value() == golden_tree());
    REQUIRE(decode_tile_to_depth(bytes, 3).value() == cut_tile(golden_tree(), 3));
  }
}

/// Version 2's golden files, and what made them.
const std::pair<const char*, CodecOptions> kGolden[] = {{"fast_v2.tile", kAllCodecs[0]},
                                                        {"dense_v2.tile", kAllCodecs[1]},
                                                        {"lossy_v2.tile", kAllCodecs[2]}};

TEST_CASE("tiles that version 2 wrote are read for ever", "[codec][golden]") {
  for (const auto& [name, options] : kGolden) {
    const auto tree = decode_tile(read_golden(name));
    REQUIRE(tree.has_value());
    REQUIRE(*tree == (options.codec == TileCodec::kLossy ? quantize(golden_tree(), options.lossy)
                                                         : golden_tree()));
  }
}

/// The worked example of FORMAT.md: one voxel that was hit, beside a cell of 80 cm seen through.
TileTree example_tree() {
  const auto model = SensorModel::standard();
  TileTree tree;
  tree.hit(CellKey{kDepth, 5}, model, Rgb{255, 128, 0});
  tree.miss(CellKey{kBrickDepth, 1}, model);
  return tree;
}

const std::pair<const char*, CodecOptions> kExamples[] = {{"example_fast_v2.tile", kAllCodecs[0]},
                                                          {"example_dense_v2.tile", kAllCodecs[1]}};

TEST_CASE("the worked examples of FORMAT.md are what is written", "[codec][golden]") {
  for (const auto& [name, options] : kExamples) {
    REQUIRE(decode_tile(read_golden(name)).value() == example_tree());
    // Zstandard may write the same otherwise one day.
    if (options.codec == TileCodec::kFast) continue;
    REQUIRE(encode_tile(example_tree(), options) == read_golden(name));
  }
}

TEST_CASE("the hashes that other decoders are held against are those of the golden tiles",
          "[codec][golden]") {
  std::ifstream file(golden_path("hashes.txt"));
  std::size_t seen = 0;
  for (std::string hash, name; file >> hash >> name; ++seen) {
    const auto tree = decode_tile(read_golden(name));
    REQUIRE(tree.has_value());
    REQUIRE(to_hex(tile_hash(TileKey::from_morton(0).value(), *tree)) == hash);
  }
  REQUIRE(seen == 7);
}

TEST_CASE("dense tiles are written as the golden ones were", "[codec][golden]") {
  REQUIRE(encode_tile(golden_tree(), kAllCodecs[1]) == read_golden("dense_v2.tile"));
}

// For new files only: unit_codec "[.write-golden]" writes the files that are not there.
TEST_CASE("golden files that are missing are written when asked for", "[.write-golden]") {
  const auto write = [](const std::string& name, const TileTree& tree, const CodecOptions& how) {
    if (std::ifstream(golden_path(name)).good()) return;
    const auto bytes = encode_tile(tree, how);
    std::ofstream(golden_path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  };
  for (const auto& [name, options] : kGolden) write(name, golden_tree(), options);
  for (const auto& [name, options] : kExamples) write(name, example_tree(), options);
}

}  // namespace
}  // namespace voxatlas
