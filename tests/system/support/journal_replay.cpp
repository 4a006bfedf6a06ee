// The oracle of several sources: a model made anew from its journals alone, record by record, in
// one process, without the atlas, its cache or its stored tiles. Prints what `voxatlas stat
// --hashes` writes. The tilestores must have run with --keep-journal, or the first record misses.
//
//   journal_replay DIR
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <stdexcept>

#include "atlas/atlas.hpp"
#include "atlas/journal_record.hpp"
#include "base/sha256.hpp"
#include "octree/tile_hash.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas {
namespace {

struct Replayed {
  TileTree tree;
  std::uint64_t version = 0;
};
using Model = std::map<TileKey, Replayed>;

template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

void apply(const JournalRecord& record, const SensorModel& sensor, Model& model) {
  for (const auto& change : record.deltas) {
    auto& tile = model[change.key];
    if (change.version != ++tile.version) {
      throw std::runtime_error(fmt::format("tile {:#x}: version {} after {}", change.key.morton(),
                                           change.version, tile.version - 1));
    }
    tile.tree.apply(or_throw(decode_delta(change.delta)), sensor);
  }
}

/// Scans of a source must stand in the journal in their order, each once.
using Order = std::map<std::pair<std::string, std::int64_t>, std::int64_t>;
void check_order(const JournalRecord& record, Order& order) {
  const auto next = order[{record.source, record.session}]++;
  if (record.seq == next) return;
  throw std::runtime_error(
      fmt::format("{}: scan {} in the journal where {} was next", record.source, record.seq, next));
}

void replay_shard(const std::string& folder, ShardId shard, Model& model) {
  const auto store = or_throw(RocksDbStore::open(folder, {}));
  const auto parameters = or_throw(Atlas::stored_parameters(*store, shard));
  if (!parameters) throw std::runtime_error(folder + ": no model");
  Order order;
  or_throw(store->replay(shard, [&](JournalPosition, ByteView bytes) -> Status {
    const auto record = or_throw(decode_record(bytes));
    check_order(record, order);
    apply(record, parameters->sensor, model);
    return {};
  }));
}

void replay(const std::string& directory) {
  Model model;
  for (ShardId shard = 0;; ++shard) {
    const auto folder = fmt::format("{}/shard-{}", directory, shard);
    if (!std::filesystem::exists(folder)) break;
    replay_shard(folder, shard, model);
  }
  for (const auto& [key, tile] : model) {
    fmt::print("{:016x} {} {}\n", key.morton(), tile.version, to_hex(tile_hash(key, tile.tree)));
  }
}

}  // namespace
}  // namespace voxatlas

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: journal_replay DIR\n");
    return 2;
  }
  try {
    voxatlas::replay(argv[1]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "journal_replay: {}\n", e.what());
    return 1;
  }
}
