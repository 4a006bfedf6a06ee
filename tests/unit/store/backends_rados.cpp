// The contract's test on a real cluster: VOX_RADOS_CONF and VOX_RADOS_POOL say which.
#include <cstdlib>
#include <random>
#include <stdexcept>

#include "backends.hpp"
#include "store/rados_store.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas::test {
namespace {

template <class T>
std::unique_ptr<T> must(Result<std::unique_ptr<T>> opened) {
  if (!opened) throw std::runtime_error(opened.error().message);
  return std::move(*opened);
}

std::string from_environment(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr) throw std::runtime_error(std::string("set ") + name);
  return value;
}

class RadosBackend final : public Backend {
 public:
  RadosBackend() { reopen(); }
  std::string name() const override { return "rados"; }
  TileStore& store() override { return *store_; }

  void reopen() override {
    store_.reset();
    RadosOptions options;
    options.conf = from_environment("VOX_RADOS_CONF");
    options.pool = from_environment("VOX_RADOS_POOL");
    options.model = model_;
    store_ = must(RadosStore::open(options));
  }

  std::unique_ptr<TileStore> open_checkpoint(const std::string& directory) override {
    return must(RocksDbStore::open(directory, {.create = false}));
  }

 private:
  std::string model_ = "test-" + std::to_string(std::random_device()());
  std::unique_ptr<RadosStore> store_;
};

}  // namespace

std::vector<std::unique_ptr<Backend>> all_backends() {
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(std::make_unique<RadosBackend>());
  return backends;
}

}  // namespace voxatlas::test
