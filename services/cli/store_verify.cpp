// verify: is everything in a model whole, in its place, and able to be applied?
#include <fmt/format.h>

#include <map>

#include "atlas/journal_record.hpp"
#include "cli/json_text.hpp"
#include "cli/progress.hpp"
#include "cli/running_copy.hpp"
#include "cli/store.hpp"
#include "codec/tile_codec.hpp"
#include "grid/region_key.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {
namespace {

struct Findings {
  std::int64_t tiles = 0, erased = 0, records = 0, deltas = 0, deltas_to_redo = 0, marks = 0;
};

/// Looks at one shard; reads only.
class ShardCheck {
 public:
  ShardCheck(ModelFolder& model, ShardId shard)
      : model_(model), shard_(shard), grid_(model.parameters().grid()) {}

  Status run() {
    if (auto ok = model_.store(shard_).verify(shard_); !ok) return ok;
    const auto each_page = [this](std::vector<StoredTile>& page) -> Status {
      for (const auto& tile : page) {
        if (auto ok = check_tile(tile); !ok) return ok;
      }
      progress_.say(fmt::format("shard {}: {} tiles", shard_, found_.tiles));
      return {};
    };
    if (auto ok = model_.for_each_page(shard_, each_page); !ok) return ok;
    auto marks = model_.store(shard_).marks(shard_);
    if (!marks) return pass_on(marks);
    found_.marks = static_cast<std::int64_t>(marks->size());
    return model_.store(shard_).replay(shard_, [this](JournalPosition position, ByteView bytes) {
      return check_record(position, bytes);
    });
  }

  const Findings& found() const { return found_; }

 private:
  Status check_place(TileKey key, const std::string& what) const {
    if (auto on_grid = grid_.tile_from_morton(key.morton()); !on_grid) {
      return pass_on(on_grid, what);
    }
    const auto owner = shard_of(key, model_.shards());
    if (owner == shard_) return {};
    return fail(ErrorCode::kCorrupt, fmt::format("{} belongs to shard {}", what, owner));
  }

  Status check_tile(const StoredTile& tile) {
    const auto what = fmt::format("tile {:#x}, version {}", tile.key.morton(), tile.version);
    if (auto ok = check_place(tile.key, what); !ok) return ok;
    ++(tile.tombstone() ? found_.erased : found_.tiles);
    if (tile.tombstone()) return {};
    if (auto tree = decode_tile(tile.bytes); !tree) return pass_on(tree, what);
    return {};
  }

  Status check_record(JournalPosition position, ByteView bytes) {
    const auto what = fmt::format("journal record {}", position);
    auto record = decode_record(bytes);
    if (!record) return pass_on(record, what);
    ++found_.records;
    for (const auto& delta : record->deltas) {
      const auto where = fmt::format("{}, tile {:#x}", what, delta.key.morton());
      if (auto ok = check_place(delta.key, where); !ok) return ok;
      if (auto decoded = decode_delta(delta.delta); !decoded) return pass_on(decoded, where);
      if (auto ok = check_version(delta, where); !ok) return ok;
    }
    return {};
  }

  Status check_version(const JournalDelta& delta, const std::string& where) {
    ++found_.deltas;
    if (!versions_.contains(delta.key)) {
      auto stored = model_.store(shard_).get(shard_, delta.key);
      if (!stored) return pass_on(stored, where);
      versions_[delta.key] = *stored ? (*stored)->version : 0;
    }
    auto& version = versions_[delta.key];
    if (delta.version <= version) return {};
    if (delta.version != version + 1) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{}: makes version {} of version {}", where, delta.version, version));
    }
    ++version;
    ++found_.deltas_to_redo;
    return {};
  }

  ModelFolder& model_;
  ShardId shard_;
  Grid grid_;
  Progress progress_;
  Findings found_;
  std::map<TileKey, std::uint64_t> versions_;  // Of tiles in the journal; it is bounded.
};

void print(ShardId shard, const Findings& found, const Status& outcome, bool json) {
  if (json) {
    JsonObject line;
    line.add("shard", std::int64_t{shard})
        .add("sound", std::int64_t{outcome.has_value()})
        .add("tiles", found.tiles)
        .add("erased", found.erased)
        .add("journal_records", found.records)
        .add("deltas_to_redo", found.deltas_to_redo)
        .add("marks", found.marks)
        .add("problem", outcome ? std::string() : outcome.error().message);
    fmt::print("{}\n", line.text());
  } else if (outcome) {
    fmt::print(
        "shard {}: sound; {} tiles, {} erased; {} journal records, {} of {} deltas to be applied "
        "again; {} marks\n",
        shard, found.tiles, found.erased, found.records, found.deltas_to_redo, found.deltas,
        found.marks);
  } else {
    fmt::print("shard {}: DAMAGED: {}\n", shard, outcome.error().message);
  }
}

}  // namespace

Status run_store_verify(const StoreOptions& options) {
  auto readable = ReadableModel::open(options.data_dir, options.url);
  if (!readable) return pass_on(readable);
  auto& model = **readable;
  ShardId damaged = 0;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    ShardCheck check(model, shard);
    const auto outcome = check.run();
    if (!outcome) ++damaged;
    print(shard, check.found(), outcome, options.json);
  }
  if (damaged == 0) return {};
  return fail(ErrorCode::kCorrupt, fmt::format("{}: {} of {} shards damaged", options.data_dir,
                                               damaged, model.shards()));
}

}  // namespace voxatlas
