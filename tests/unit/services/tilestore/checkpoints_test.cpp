#include "tilestore/checkpoints.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "store/memory_store.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

checkpoint_request_t question(std::int64_t client, std::int64_t id) {
  checkpoint_request_t request{};
  request.client = client;
  request.id = id;
  return request;
}

/// Asks until the answer is there, as a client does.
checkpoint_reply_t ask(Checkpoints& checkpoints, const checkpoint_request_t& request) {
  for (;;) {
    if (auto reply = checkpoints.answer(request)) return *reply;
  }
}

TEST_CASE("a copy is made once a question, and holds what the store had when asked",
          "[tilestore]") {
  const test::TempDir folder;
  MemoryStore store;
  const auto epoch = store.acquire(0).value();
  const auto key = TileKey::from_morton(5).value();
  const std::vector<StoredTile> before{{key, 4, {1, 2}}}, after{{key, 5, {3}}};
  REQUIRE(store.put(0, epoch, before).has_value());
  Checkpoints checkpoints(store, folder / "model");

  const auto first = ask(checkpoints, question(7, 1));
  REQUIRE(store.put(0, epoch, after).has_value());
  const auto second = ask(checkpoints, question(8, 1));
  const auto again = ask(checkpoints, question(7, 1));

  REQUIRE(first.error == "");
  REQUIRE(again.error == "");
  REQUIRE(first.client == 7);
  REQUIRE(again.folder == first.folder);
  REQUIRE(second.folder != first.folder);
  const auto version = [&](const checkpoint_reply_t& reply) {
    const auto copy = MemoryStore::load(folder / ("model/" + reply.folder + "/shard-0")).value();
    return copy->get(0, key).value()->version;
  };
  REQUIRE(version(first) == 4);
  REQUIRE(version(second) == 5);
}

TEST_CASE("a copy that cannot be made is told with its reason, again and again", "[tilestore]") {
  const test::TempDir folder;
  MemoryStore store;
  std::ofstream(folder / "model") << "no folder";
  Checkpoints checkpoints(store, folder / "model");
  for (int i = 0; i < 2; ++i) {
    const auto reply = ask(checkpoints, question(7, 1));
    REQUIRE(reply.folder == "");
    REQUIRE(reply.error.find("cannot make") != std::string::npos);
  }
}

}  // namespace
}  // namespace voxatlas
