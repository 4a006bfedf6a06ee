#include "atlas/atlas.hpp"

#include <fmt/format.h>

#include "atlas/atlas_state.hpp"
#include "store/store_copy.hpp"

namespace voxatlas {

/// The named value of a shard that holds encode_parameters' bytes.
static constexpr const char* kParametersName = "parameters";

Atlas::Atlas(std::unique_ptr<State> state) : state_(std::move(state)) {}
Atlas::~Atlas() = default;

Result<std::optional<ModelParameters>> Atlas::stored_parameters(TileStore& store, ShardId shard) {
  auto unfinished = is_unfinished(store, shard);
  if (!unfinished) return pass_on(unfinished);
  if (*unfinished) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("shard {} is an unfinished copy: run `voxatlas store copy` again", shard));
  }
  auto bytes = store.value(shard, kParametersName);
  if (!bytes) return pass_on(bytes);
  if (!*bytes) return std::optional<ModelParameters>();
  auto parameters = decode_parameters(**bytes);
  if (!parameters) return pass_on(parameters, fmt::format("shard {}", shard));
  return std::optional(*parameters);
}

std::vector<std::string> Atlas::value_names() { return {kParametersName}; }

Result<std::unique_ptr<Atlas>> Atlas::open(TileStore& store, ShardId shard,
                                           const ModelParameters& parameters,
                                           const AtlasOptions& options) {
  if (auto ok = parameters.check(); !ok) return pass_on(ok);
  if (shard >= parameters.shards) {
    return fail(ErrorCode::kOutOfRange, fmt::format("shard {}: the model has shards 0 to {}", shard,
                                                    parameters.shards - 1));
  }
  // Before the shard is acquired: who may not have it must not take it from its owner.
  auto stored = stored_parameters(store, shard);
  if (!stored) return pass_on(stored);
  if (*stored && **stored != parameters) {
    return fail(ErrorCode::kInvalid, fmt::format("shard {} was made with other parameters: {}",
                                                 shard, describe_difference(**stored, parameters)));
  }
  auto state = std::make_unique<State>(store, shard, parameters, options);
  if (auto ok = state->acquire(); !ok) return pass_on(ok);
  if (!*stored) {
    auto put = store.put_value(shard, state->epoch, kParametersName, encode_parameters(parameters));
    if (!put) return pass_on(put);
  }
  if (auto ok = state->recover(); !ok) return pass_on(ok);
  state->reported = state->journal.last();
  return std::unique_ptr<Atlas>(new Atlas(std::move(state)));
}

const ModelParameters& Atlas::parameters() const { return state_->parameters; }
ShardId Atlas::shard() const { return state_->shard; }
Epoch Atlas::epoch() const { return state_->epoch; }

Status Atlas::commit(std::span<const ShardScan> scans, const Tell& tell) {
  return state_->commit(scans, tell);
}

Status Atlas::check_scan(const ShardScan& scan) const { return state_->check_scan(scan); }

std::int64_t Atlas::mark(const std::string& source, std::int64_t session) const {
  return state_->mark({source, session});
}

std::vector<Mark> Atlas::marks() const { return state_->mark_list(); }

Result<Atlas::Tile> Atlas::tile(TileKey key) {
  if (auto ok = state_->settle(); !ok) return pass_on(ok);
  auto tile = state_->load(key);
  if (!tile) return pass_on(tile);
  if (*tile == nullptr) return Tile{};
  return Tile{&(*tile)->tree, (*tile)->version};
}

Result<EncodedTile> Atlas::encoded(TileKey key, int depth) {
  if (auto ok = state_->settle(); !ok) return pass_on(ok);
  return state_->encoded(key, depth);
}

Result<std::vector<TileInfo>> Atlas::list(TileKey from, std::size_t limit) {
  if (auto ok = state_->settle(); !ok) return pass_on(ok);
  return state_->list(from, limit);
}

Result<std::optional<std::uint64_t>> Atlas::take_encoded(const EncodedTile& encoded) {
  if (auto ok = state_->settle(); !ok) return pass_on(ok);
  return state_->take_encoded(encoded);
}

Status Atlas::flush_some(std::size_t max_tiles) {
  if (auto ok = state_->settle(); !ok) return ok;
  if (auto ok = state_->write_oldest(max_tiles); !ok) return ok;
  return state_->trim();
}

Status Atlas::flush() {
  if (auto ok = state_->settle(); !ok) return ok;
  if (auto ok = state_->write_oldest(state_->cache.dirty_tiles()); !ok) return ok;
  return state_->trim();
}

void Atlas::limit_cache(std::size_t bytes) {
  state_->options.cache_bytes = bytes;
  state_->cache.evict(bytes, std::nullopt);
}

std::vector<TileInfo> Atlas::rested(std::size_t limit) {
  if (!state_->settle()) return {};  // Whoever writes next is told.
  return state_->rested_tiles(limit);
}

AtlasStats Atlas::stats() const {
  AtlasStats stats = state_->counts;
  stats.cached_tiles = state_->cache.tiles();
  stats.cached_bytes = state_->cache.bytes();
  stats.dirty_tiles = state_->cache.dirty_tiles();
  stats.resting_tiles = state_->rested.size();
  stats.journal_bytes = state_->journal.bytes();
  return stats;
}

}  // namespace voxatlas
