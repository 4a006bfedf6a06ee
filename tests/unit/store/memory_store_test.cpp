#include "store/memory_store.hpp"

#include <catch2/catch.hpp>

#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

TEST_CASE("an injected fault happens before or after the work, as told", "[store]") {
  MemoryStore store;
  const auto epoch = store.acquire(0).value();
  const std::vector<Bytes> record{{7}};
  store.inject([](StoreCall call) -> std::optional<StoreFault> {
    if (call != StoreCall::kAppend) return std::nullopt;
    return StoreFault{ErrorCode::kNoSpace, false};
  });
  REQUIRE(store.append(0, epoch, record).error().code == ErrorCode::kNoSpace);
  store.inject([](StoreCall call) -> std::optional<StoreFault> {
    if (call != StoreCall::kAppend) return std::nullopt;
    return StoreFault{ErrorCode::kUnknown, true};
  });
  REQUIRE(store.append(0, epoch, record).error().code == ErrorCode::kUnknown);
  store.inject({});
  REQUIRE(store.append(0, epoch, record).value() == 2);
}

TEST_CASE("a memory store's checkpoint that was damaged is refused", "[store]") {
  const test::TempDir folder;
  MemoryStore store;
  REQUIRE(store.acquire(1).has_value());
  REQUIRE(store.checkpoint(folder / "copy").has_value());
  REQUIRE(MemoryStore::load(folder / "copy").has_value());
  std::filesystem::resize_file(folder / "copy/memory_store", 20);
  REQUIRE(MemoryStore::load(folder / "copy").error().code == ErrorCode::kCorrupt);
  REQUIRE(MemoryStore::load(folder / "none").error().code == ErrorCode::kIo);
}

}  // namespace
}  // namespace voxatlas
