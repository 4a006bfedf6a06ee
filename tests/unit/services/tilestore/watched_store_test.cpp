#include "tilestore/watched_store.hpp"

#include <catch2/catch.hpp>
#include <future>

#include "base/utime.hpp"
#include "store/memory_store.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a watched store says since when its oldest call waits", "[tilestore]") {
  auto memory = std::make_unique<MemoryStore>();
  std::promise<void> reached, go_on;
  memory->inject([&](StoreCall call) -> std::optional<StoreFault> {
    if (call != StoreCall::kAppend) return std::nullopt;
    reached.set_value();
    go_on.get_future().wait();
    return std::nullopt;
  });
  WatchedStore store(std::move(memory));
  const auto epoch = store.acquire(0).value();
  CHECK_FALSE(store.waiting_since().has_value());
  const Bytes record = {1, 2, 3};
  const auto before = steady_utime();

  auto append = std::async(std::launch::async, [&] {
    return store.append(0, epoch, {&record, 1}).value();
  });
  reached.get_future().wait();

  const auto since = store.waiting_since();
  REQUIRE(since.has_value());
  CHECK(*since >= before);
  CHECK(*since <= steady_utime());
  CHECK(store.waiting_since() == since);
  go_on.set_value();
  CHECK(append.get() == 1);
  CHECK_FALSE(store.waiting_since().has_value());
}

TEST_CASE("a call that fails waits no longer", "[tilestore]") {
  auto memory = std::make_unique<MemoryStore>();
  memory->inject([](StoreCall) { return StoreFault{ErrorCode::kIo, false}; });
  WatchedStore store(std::move(memory));
  CHECK_FALSE(store.acquire(0).has_value());
  CHECK_FALSE(store.waiting_since().has_value());
}

}  // namespace
}  // namespace voxatlas
