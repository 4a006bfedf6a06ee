// future_model KIND SHARD_FOLDER: turns a shard at rest into one that a newer voxatlas wrote, as
// far as one byte that says so. KIND: format (of the store), parameters, journal, tile.
#include <fmt/format.h>
#include <rocksdb/db.h>

#include <memory>
#include <string_view>

#include "base/check.hpp"
#include "store/store_format.hpp"

namespace voxatlas {
namespace {

class Shard {
 public:
  explicit Shard(const std::string& folder) {
    const rocksdb::Options options;
    std::vector<std::string> names;
    must(rocksdb::DB::ListColumnFamilies(options, folder, &names));
    std::vector<rocksdb::ColumnFamilyDescriptor> wanted;
    for (const auto& name : names) wanted.emplace_back(name, rocksdb::ColumnFamilyOptions{});
    rocksdb::DB* db = nullptr;
    must(rocksdb::DB::Open(options, folder, wanted, &families_, &db));
    db_.reset(db);
  }
  ~Shard() {
    for (auto* family : families_) must(db_->DestroyColumnFamilyHandle(family));
  }

  /// Adds `more` to the byte at `at` of the body of the first row from `from` on, and seals it
  /// anew.
  void make_newer(const std::string& family, const std::string& from, std::size_t at,
                  std::uint8_t more) {
    auto* handle = find(family);
    const std::unique_ptr<rocksdb::Iterator> row(db_->NewIterator({}, handle));
    row->Seek(from);
    VOX_CHECK(row->Valid());
    const auto key = row->key().ToString();
    const auto sealed = row->value().ToString();
    const auto body = unseal(key, sealed, "the row");
    VOX_CHECK(body.has_value() && body->size() > at);
    Bytes changed(body->begin(), body->end());
    changed[at] = static_cast<std::uint8_t>(changed[at] + more);
    rocksdb::WriteOptions synced;
    synced.sync = true;
    must(db_->Put(synced, handle, key, seal(key, changed)));
  }

 private:
  static void must(const rocksdb::Status& status) {
    if (!status.ok()) fmt::print(stderr, "future_model: {}\n", status.ToString());
    VOX_CHECK(status.ok());
  }
  rocksdb::ColumnFamilyHandle* find(const std::string& name) const {
    for (auto* family : families_) {
      if (family->GetName() == name) return family;
    }
    VOX_CHECK(false);
  }

  std::unique_ptr<rocksdb::DB> db_;
  std::vector<rocksdb::ColumnFamilyHandle*> families_;
};

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  VOX_CHECK(argc == 3);
  voxatlas::Shard shard(argv[2]);
  const std::string_view kind = argv[1];
  constexpr std::size_t kTileVersionAt = 8 + 4;  // Behind the row's u64 and the tile's magic.
  if (kind == "format") {
    shard.make_newer("default", "voxatlas store", 0, 1);
  } else if (kind == "parameters") {
    shard.make_newer("state", voxatlas::name_key(0, "v/parameters"), 0, 2);
  } else if (kind == "journal") {
    shard.make_newer("journal", voxatlas::row_key(0, 0), 0, 1);
  } else if (kind == "tile") {
    shard.make_newer("tiles", voxatlas::row_key(0, 0), kTileVersionAt, 100);
  } else {
    return 2;
  }
  return 0;
}
