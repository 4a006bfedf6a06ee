#include "backends.hpp"

#include <stdexcept>

#include "store/memory_store.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas::test {
namespace {

template <class T>
std::unique_ptr<T> must(Result<std::unique_ptr<T>> opened) {
  if (!opened) throw std::runtime_error(opened.error().message);
  return std::move(*opened);
}

class MemoryBackend final : public Backend {
 public:
  std::string name() const override { return "memory"; }
  TileStore& store() override { return *store_; }

  void reopen() override {
    const auto copy = path("reopen" + std::to_string(++copies_));
    if (auto ok = store_->checkpoint(copy); !ok) throw std::runtime_error(ok.error().message);
    store_ = must(MemoryStore::load(copy));
  }

  std::unique_ptr<TileStore> open_checkpoint(const std::string& directory) override {
    return must(MemoryStore::load(directory));
  }

 private:
  std::unique_ptr<MemoryStore> store_ = std::make_unique<MemoryStore>();
  int copies_ = 0;
};

class RocksDbBackend final : public Backend {
 public:
  RocksDbBackend() { reopen(); }
  std::string name() const override { return "rocksdb"; }
  TileStore& store() override { return *store_; }

  void reopen() override {
    store_.reset();
    RocksDbOptions small;  // So that a short test reaches the table files too.
    small.write_buffer_bytes = 64 << 10;
    small.max_wal_bytes = 64 << 10;
    store_ = must(RocksDbStore::open(path("store"), small));
  }

  std::unique_ptr<TileStore> open_checkpoint(const std::string& directory) override {
    return must(RocksDbStore::open(directory, {.create = false}));
  }

 private:
  std::unique_ptr<RocksDbStore> store_;
};

}  // namespace

std::vector<std::unique_ptr<Backend>> all_backends() {
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(std::make_unique<MemoryBackend>());
  backends.push_back(std::make_unique<RocksDbBackend>());
  return backends;
}

}  // namespace voxatlas::test
