// stat and compact: what a model at rest holds, and on how many bytes.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "base/sha256.hpp"
#include "cli/json_text.hpp"
#include "cli/progress.hpp"
#include "cli/running_copy.hpp"
#include "cli/store.hpp"
#include "codec/tile_codec.hpp"
#include "octree/tile_hash.hpp"

namespace voxatlas {
namespace {

struct ShardFigures {
  std::int64_t tiles = 0, erased = 0, tile_bytes = 0, journal_records = 0, journal_bytes = 0;
  std::int64_t marks = 0, disk_bytes = 0;
  std::int64_t fast = 0, dense = 0, lossy = 0;  ///< Of the tiles, by codec.
};

/// Tiles that do not say which they are count as none: `verify` names them.
void count_codec(const StoredTile& tile, ShardFigures& figures) {
  const auto codec = codec_of(tile.bytes);
  if (!codec) return;
  if (*codec == TileCodec::kFast) ++figures.fast;
  if (*codec == TileCodec::kDense) ++figures.dense;
  if (*codec == TileCodec::kLossy) ++figures.lossy;
}

Result<ShardFigures> measure(ModelFolder& model, ShardId shard) {
  ShardFigures figures;
  auto& store = model.store(shard);
  auto scanned = model.for_each_page(shard, [&](std::vector<StoredTile>& page) -> Status {
    for (const auto& tile : page) {
      ++(tile.tombstone() ? figures.erased : figures.tiles);
      figures.tile_bytes += static_cast<std::int64_t>(tile.bytes.size());
      if (!tile.tombstone()) count_codec(tile, figures);
    }
    return {};
  });
  if (!scanned) return pass_on(scanned);
  auto replayed = store.replay(shard, [&](JournalPosition, ByteView record) -> Status {
    ++figures.journal_records;
    figures.journal_bytes += static_cast<std::int64_t>(record.size());
    return {};
  });
  if (!replayed) return pass_on(replayed);
  auto marks = store.marks(shard);
  if (!marks) return pass_on(marks);
  figures.marks = static_cast<std::int64_t>(marks->size());
  auto disk = store.disk_bytes();
  if (!disk) return pass_on(disk);
  figures.disk_bytes = static_cast<std::int64_t>(*disk);
  return figures;
}

/// Of what the model knows, its journals applied.
Result<std::vector<std::pair<TileKey, std::string>>> hash_lines(ModelFolder& model) {
  std::vector<std::pair<TileKey, std::string>> lines;
  Progress progress;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    auto atlas = model.atlas(shard);
    if (!atlas) return pass_on(atlas);
    for (auto from = TileKey::from_morton(0); from;) {
      auto page = (*atlas)->list(*from, 256);
      if (!page) return pass_on(page);
      if (page->empty()) break;
      for (const auto& info : *page) {
        auto tile = (*atlas)->tile(info.key);
        if (!tile) return pass_on(tile);
        lines.emplace_back(info.key, fmt::format("{:016x} {} {}\n", info.key.morton(), info.version,
                                                 to_hex(tile_hash(info.key, *tile->tree))));
      }
      from = TileKey::from_morton(page->back().key.morton() + 1);
      progress.say(fmt::format("{} tiles", lines.size()));
    }
  }
  std::ranges::sort(lines);
  return lines;
}

Status write_file(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text;
  out.close();
  if (!out) return fail(ErrorCode::kIo, fmt::format("{}: cannot be written", path));
  return {};
}

Status write_hashes(ModelFolder& model, const std::string& path) {
  auto lines = hash_lines(model);
  if (!lines) return pass_on(lines);
  std::string text;
  for (const auto& [key, line] : *lines) text += line;
  return write_file(path, text);
}

/// The journals' scans included. The source comes last: it may hold spaces.
Status write_marks(ModelFolder& model, const std::string& path) {
  std::string text;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    auto atlas = model.atlas(shard);
    if (!atlas) return pass_on(atlas);
    for (const auto& mark : (*atlas)->marks()) {
      text += fmt::format("{} {} {} {}\n", shard, mark.seq, mark.session, mark.source);
    }
  }
  return write_file(path, text);
}

void print(ShardId shard, const ShardFigures& figures, bool json) {
  if (json) {
    JsonObject line;
    line.add("shard", std::int64_t{shard})
        .add("tiles", figures.tiles)
        .add("fast", figures.fast)
        .add("dense", figures.dense)
        .add("lossy", figures.lossy)
        .add("erased", figures.erased)
        .add("tile_bytes", figures.tile_bytes)
        .add("journal_records", figures.journal_records)
        .add("journal_bytes", figures.journal_bytes)
        .add("marks", figures.marks)
        .add("disk_bytes", figures.disk_bytes);
    fmt::print("{}\n", line.text());
    return;
  }
  fmt::print(
      "shard {}: {} tiles of {} bytes ({} fast, {} dense, {} lossy), {} erased; journal {} records "
      "of {} bytes; {} marks; {} bytes on disk\n",
      shard, figures.tiles, figures.tile_bytes, figures.fast, figures.dense, figures.lossy,
      figures.erased, figures.journal_records, figures.journal_bytes, figures.marks,
      figures.disk_bytes);
}

}  // namespace

Status run_store_stat(const StoreOptions& options) {
  auto readable = ReadableModel::open(options.data_dir, options.url);
  if (!readable) return pass_on(readable);
  auto& model = **readable;
  for (ShardId shard = 0; shard < model.shards(); ++shard) {
    auto figures = measure(model, shard);
    if (!figures) return pass_on(figures, fmt::format("shard {}", shard));
    print(shard, *figures, options.json);
  }
  if (!options.marks.empty()) {
    if (auto written = write_marks(model, options.marks); !written) return written;
  }
  if (options.hashes.empty()) return {};
  return write_hashes(model, options.hashes);
}

Status run_store_compact(const StoreOptions& options) {
  auto model = ModelFolder::open(options.data_dir);
  if (!model) return pass_on(model);
  for (ShardId shard = 0; shard < model->shards(); ++shard) {
    auto* store = dynamic_cast<RocksDbStore*>(&model->store(shard));
    if (store == nullptr) {
      return fail(ErrorCode::kInvalid, options.data_dir + ": a cluster compacts by itself");
    }
    auto before = store->disk_bytes();
    if (!before) return pass_on(before);
    if (auto compacted = store->compact(); !compacted) return compacted;
    auto after = store->disk_bytes();
    if (!after) return pass_on(after);
    fmt::print("shard {}: {} bytes, {} before\n", shard, *after, *before);
  }
  return {};
}

}  // namespace voxatlas
