#include "codec/node_stream.hpp"

#include <catch2/catch.hpp>

#include "unit/codec/codec_trees.hpp"

namespace voxatlas {
namespace {

using test::random_tree;

TEST_CASE("a tile's nodes come back as they went", "[codec][oracle]") {
  INFO("VOX_SEED=" << test::seed());
  test::RandomOctree random(test::seed());
  for (int i = 0; i < 300; ++i) {
    const auto tree = random_tree(random);
    const auto bytes = encode_nodes(tree);
    const auto back = decode_nodes(bytes);
    REQUIRE(back.has_value());
    REQUIRE(back->leaves() == tree.leaves());
    REQUIRE(*back == tree);
    REQUIRE(encode_nodes(*back) == bytes);
  }
}

TEST_CASE("an empty tile and a tile that is one leaf have an encoding", "[codec]") {
  TileTree tree;
  REQUIRE(encode_nodes(tree) == Bytes{0});
  REQUIRE(decode_nodes(Bytes{0}).value().empty());
  tree.set(CellKey{}, {-1234, {}});
  REQUIRE(encode_nodes(tree).size() == 6);
  REQUIRE(decode_nodes(encode_nodes(tree)).value() == tree);
}

TEST_CASE("the nodes' bytes are those of FORMAT.md's example", "[codec][golden]") {
  TileTree tree;
  Colour orange;
  orange.add({255, 128, 0});
  tree.set(CellKey{1, 0}, {-400, {}});
  tree.set(CellKey{1, 5}, {850, orange});
  tree.set(CellKey{2, 8 * 7 + 1}, {850, {}});
  tree.set(CellKey{2, 8 * 7 + 6}, {-400, {}});
  const Bytes expected{0x02,        // The root is an inner node.
                       0x02, 0x02,  // Child masks, leaf masks.
                       0xa1, 0x42,  // Children 0, 5, 7 of the root; 1, 6 of its 7th.
                       0x21, 0x42,  // Of these, leaves: 0, 5; 1, 6.
                       0x02, 0x70, 0xfe, 0x52, 0x03,  // Palette: -400 and 850, twice each.
                       0x00, 0x01, 0x01, 0x00,        // The four leaves' values.
                       0x01, 0x01,                    // One colour: the first occupied leaf's.
                       0x01,                          // Seen once.
                       0xff, 0x80, 0x00, 0x00, 0x00, 0x00};  // r, g, b: high bytes, low bytes.
  REQUIRE(encode_nodes(tree) == expected);
  REQUIRE(decode_nodes(expected).value() == tree);
}

TEST_CASE("truncated at any length, nodes are refused", "[codec]") {
  test::RandomOctree random(test::seed());
  const auto bytes = encode_nodes(random_tree(random));
  REQUIRE(bytes.size() > 50);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    REQUIRE(decode_nodes(ByteView(bytes).first(size)).error().code == ErrorCode::kCorrupt);
  }
  auto longer = bytes;
  longer.push_back(0);
  REQUIRE(decode_nodes(longer).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("nodes that the encoder does not write are refused, with the reason", "[codec]") {
  const auto refused = [](const Bytes& bytes, const std::string& reason) {
    const auto tree = decode_nodes(bytes);
    REQUIRE_FALSE(tree.has_value());
    REQUIRE(tree.error().code == ErrorCode::kCorrupt);
    CAPTURE(tree.error().message);
    REQUIRE(tree.error().message.find(reason) != std::string::npos);
  };
  refused({3}, "root kind 3");
  refused({2, 1, 1, 0x00, 0x00}, "no octree");                      // No children.
  refused({2, 1, 1, 0x01, 0x03}, "no octree");                      // A leaf that is none.
  refused({2, 1, 1, 0x03, 0x01}, "no octree");                      // A node is missing.
  refused({2, 2, 1, 0x01, 0x01, 0x01}, "no octree");                // One too many.
  refused({2, 0xff, 0xff, 0xff, 0xff, 0x0f, 1}, "too short");       // 2^32 masks said.
  refused({1, 2, 1, 0, 2, 0, 0, 0}, "palette of 2 values for 1");   // More values than leaves.
  refused({1, 1, 1, 0, 1, 0}, "value 1 of a palette of 1");         // Off the palette.
  refused({2, 1, 1, 3, 3, 2, 2, 0, 1, 0, 0, 1, 0}, "wrong place");  // 2 before 1, as often.
  refused({2, 1, 1, 3, 3, 2, 1, 0, 2, 0, 0, 0, 0}, "wrong place");  // 2 is of no leaf.
  refused({1, 1, 1, 0, 0, 1, 1, 17, 0, 0, 0, 0, 0, 0}, "seen 17 times");   // Above 16.
  refused({1, 1, 1, 0, 0, 1, 3, 1, 0, 0, 0, 0, 0, 0}, "1 colours said");   // A bit too many.
  refused({1, 1, 0xff, 0xff, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0}, "0 flagged");  // Free has no colour.
  refused({2, 1, 1, 0xff, 0xff, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "not pruned");
}

TEST_CASE("the paper's lossless bits of a full tree are 122 234 001", "[codec]") {
  TileTree::Counts full;
  full.leaves = kMaxLeaves;
  full.inner = kMaxInner;
  REQUIRE(full.leaves == 2'097'152);
  REQUIRE(full.inner == 299'593);
  REQUIRE(paper_lossless_bits(full) == 122'234'001);
  const double raw_bits = 64.0 * static_cast<double>(full.leaves + full.inner);
  REQUIRE(1 - 122'234'001 / raw_bits == Approx(0.203125).margin(1e-7));
}

TEST_CASE("a full tree of different voxels keeps within the bounds", "[codec]") {
  TileTree tree;
  for (std::uint32_t code = 0; code < kMaxLeaves; ++code) {
    tree.set(CellKey{kDepth, code}, {static_cast<LogOdds>(code % 60'000 / 2), {}});
  }
  const auto counts = tree.counts();
  REQUIRE(counts.leaves == kMaxLeaves);
  REQUIRE(counts.inner == kMaxInner);
  REQUIRE(paper_lossless_bits(counts) == 122'234'001);
  const auto bytes = encode_nodes(tree);
  REQUIRE(bytes.size() < kMaxNodeBytes);
  REQUIRE(decode_nodes(bytes).value() == tree);
}

}  // namespace
}  // namespace voxatlas
