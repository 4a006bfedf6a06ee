#include "bus/send_queue.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

Bytes random_bytes(std::mt19937_64& rng, std::size_t count) {
  Bytes bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
  return bytes;
}

TEST_CASE("a queue holds messages until all their chunks are committed", "[bus]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  SendQueue queue(7, 1'000);
  std::vector<Bytes> offered;
  for (const std::size_t size : {2'500, 0, 1'000, 1'001}) {  // 3, 1, 1 and 2 chunks.
    offered.push_back(random_bytes(rng, size));
    REQUIRE(queue.push(MessageKind::kScan, offered.back()) ==
            static_cast<std::int64_t>(offered.size()) - 1);
  }
  REQUIRE(queue.offered() == 7);
  REQUIRE(queue.payloads() == offered);
  Bytes first;
  for (std::int64_t seq = 0; seq < 3; ++seq) {
    const auto& chunk = queue.at(seq);
    REQUIRE(chunk.head.seq == seq);
    REQUIRE(chunk.head.index == seq);
    REQUIRE(chunk.head.count == 3);
    first.insert(first.end(), chunk.data.begin(), chunk.data.end());
  }
  REQUIRE(first == offered.front());
  REQUIRE_FALSE(queue.free_below(2));
  REQUIRE(queue.free_below(6));  // In the middle of the last.
  REQUIRE(queue.base() == 5);
  REQUIRE(queue.committed_messages() == 3);
  REQUIRE(queue.held_bytes() == 1'001);
  REQUIRE(queue.at(6).head.message == 3);
  REQUIRE(queue.payloads() == std::vector<Bytes>{offered.back()});
  REQUIRE(queue.free_below(7));
  REQUIRE(queue.empty());
}

}  // namespace
}  // namespace voxatlas
