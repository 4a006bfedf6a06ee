// What a shard remembers of itself between calls, and how its rows are read.
#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <deque>
#include <system_error>

#include "store/rados_state.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

std::string shard_object(ShardId id) { return fmt::format("shard-{}", id); }

std::string region_object(ShardId id, std::uint64_t region) {
  return fmt::format("region-{}-{:016x}", id, region);
}

std::string numbered_row(std::string_view prefix, std::uint64_t number) {
  std::string row(prefix);
  for (int shift = 56; shift >= 0; shift -= 8) row.push_back(static_cast<char>(number >> shift));
  return row;
}

Result<std::uint64_t> number_of_row(std::string_view prefix, std::string_view row) {
  if (row.size() != prefix.size() + 8) {
    return fail(ErrorCode::kCorrupt, fmt::format("a row's key of {} bytes", row.size()));
  }
  std::uint64_t number = 0;
  for (const char c : row.substr(prefix.size())) {
    number = number << 8 | static_cast<std::uint8_t>(c);
  }
  return number;
}

librados::bufferlist buffer(std::string_view text) {
  librados::bufferlist list;
  list.append(text.data(), static_cast<unsigned>(text.size()));
  return list;
}

std::string text_of(librados::bufferlist& buffer) { return {buffer.c_str(), buffer.length()}; }

RadosStore::State::Shard& RadosStore::State::slot(ShardId id) {
  const std::lock_guard guard(shards_mutex);
  auto& entry = shards[id];
  if (!entry) entry = std::make_unique<Shard>();
  return *entry;
}

Result<RadosStore::State::Owned> RadosStore::State::lock(ShardId id) {
  auto& shard = slot(id);
  Owned owned{std::unique_lock(shard.mutex), &shard};
  if (!shard.loaded) {
    if (auto ok = load(id, shard); !ok) return pass_on(ok);
  }
  return owned;
}

Result<RadosStore::State::Owned> RadosStore::State::own(ShardId id, Epoch epoch) {
  auto owned = lock(id);
  if (!owned) return owned;
  if (owned->shard->epoch != epoch) return fenced(id, epoch, owned->shard->epoch);
  return owned;
}

Status RadosStore::State::load(ShardId id, Shard& shard) {
  auto epoch = stored_epoch(id);
  if (!epoch) return pass_on(epoch);
  auto trimmed = named_number(id, kTrimmedRow);
  if (!trimmed) return pass_on(trimmed);
  auto last = last_position(id, *trimmed);
  if (!last) return pass_on(last);
  constexpr std::size_t kAtOnce = 1'000;
  shard.regions.clear();
  std::string after;
  for (;;) {
    auto listed = rows(shard_object(id), after, std::string(kRegionRow), kAtOnce);
    if (!listed) return pass_on(listed);
    for (const auto& [row, value] : *listed) {
      auto region = number_of_row(kRegionRow, row);
      if (!region) return pass_on(region, shard_object(id));
      shard.regions.insert(*region);
      after = row;
    }
    if (listed->size() < kAtOnce) break;
  }
  shard.epoch = *epoch;
  shard.trimmed = *trimmed;
  shard.last = *last;
  shard.loaded = true;
  return {};
}

/// 0 where the shard never had an owner.
Result<Epoch> RadosStore::State::stored_epoch(ShardId id) {
  librados::bufferlist value;
  const int got = pool.getxattr(shard_object(id), kEpochAttribute, value);
  if (got == -ENOENT || got == -ENODATA) return 0;
  if (got < 0) return tl::unexpected(error_of(got, "reading an epoch"));
  const auto text = text_of(value);
  Epoch epoch = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), epoch);
  if (wrong != std::errc() || end != text.data() + text.size()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{}: its epoch is \"{}\"", shard_object(id), text));
  }
  return epoch;
}

/// Of the journal's last row, or of the last trimmed one where there is none. The journal is
/// bounded by the atlas, so its keys are few.
Result<JournalPosition> RadosStore::State::last_position(ShardId id, JournalPosition trimmed) {
  constexpr std::uint64_t kAtOnce = 1'000;
  JournalPosition last = trimmed;
  std::string after = numbered_row(kJournalRow, trimmed);
  for (;;) {
    librados::ObjectReadOperation read;
    std::set<std::string> keys;
    bool more = false;
    int code = 0;
    read.omap_get_keys2(after, kAtOnce, &keys, &more, &code);
    const int got = pool.operate(shard_object(id), &read, nullptr);
    if (got == -ENOENT) return last;
    if (got < 0) return tl::unexpected(error_of(got, "reading the journal's keys"));
    for (const auto& row : keys) {
      if (!row.starts_with(kJournalRow)) return last;
      auto position = number_of_row(kJournalRow, row);
      if (!position) return pass_on(position, shard_object(id));
      last = *position;
      after = row;
    }
    if (!more) return last;
  }
}

Result<RadosStore::State::Rows> RadosStore::State::rows(const std::string& object,
                                                        const std::string& after,
                                                        const std::string& prefix,
                                                        std::size_t limit) {
  Rows found;
  bool more = true;
  for (std::string from = after; more && found.size() < limit;) {
    librados::ObjectReadOperation read;
    Rows page;
    int code = 0;
    read.omap_get_vals2(from, prefix, limit - found.size(), &page, &more, &code);
    const int got = pool.operate(object, &read, nullptr);
    if (got == -ENOENT) return Rows();
    if (got < 0) return tl::unexpected(error_of(got, "reading " + object));
    if (page.empty()) break;
    from = page.rbegin()->first;
    found.merge(page);
  }
  return found;
}

Result<std::map<std::string, StoredTile>> RadosStore::State::tiles_of(
    ShardId id, const std::map<std::uint64_t, std::set<std::string>>& wanted) {
  struct Question {
    std::string object;
    librados::ObjectReadOperation read;
    Rows found;
    int code = 0;
    RadosCompletion answer;  // Last: it is waited for before the others go.
  };
  std::deque<Question> questions;
  for (const auto& [region, rows] : wanted) {
    auto& question = questions.emplace_back();
    question.object = region_object(id, region);
    question.read.omap_get_vals_by_keys(rows, &question.found, &question.code);
    const int begun =
        pool.aio_operate(question.object, question.answer.completion, &question.read, nullptr);
    question.answer.begun = begun >= 0;
    if (begun < 0) return tl::unexpected(error_of(begun, "reading " + question.object));
  }
  std::map<std::string, StoredTile> tiles;
  for (auto& question : questions) {
    const int got = question.answer.result();
    if (got == -ENOENT) continue;
    if (got < 0) return tl::unexpected(error_of(got, "reading " + question.object));
    for (auto& [key, value] : question.found) {
      auto tile = unseal_tile(key, text_of(value));
      if (!tile) return pass_on(tile, question.object);
      tiles.emplace(key, std::move(*tile));
    }
  }
  return tiles;
}

Result<std::optional<Bytes>> RadosStore::State::named(ShardId id, std::string_view name) {
  librados::ObjectReadOperation read;
  Rows found;
  int code = 0;
  read.omap_get_vals_by_keys({std::string(name)}, &found, &code);
  const int got = pool.operate(shard_object(id), &read, nullptr);
  if (got == -ENOENT || (got == 0 && found.empty())) return std::optional<Bytes>();
  const auto what = fmt::format("{}, row \"{}\"", shard_object(id), name);
  if (got < 0) return tl::unexpected(error_of(got, what));
  const auto sealed = text_of(found.begin()->second);
  auto body = unseal(name_key(id, name), sealed, what);
  if (!body) return pass_on(body);
  return std::optional<Bytes>(Bytes(body->begin(), body->end()));
}

/// A number of the shard, 0 where it was never written.
Result<std::uint64_t> RadosStore::State::named_number(ShardId id, std::string_view name) {
  auto bytes = named(id, name);
  if (!bytes) return pass_on(bytes);
  if (!*bytes) return 0;
  ByteReader reader(**bytes);
  const auto number = reader.get<std::uint64_t>();
  if (reader.at_end()) return number;
  return fail(ErrorCode::kCorrupt, fmt::format("{}, row \"{}\": {} bytes, not 8", shard_object(id),
                                               name, (*bytes)->size()));
}

Error RadosStore::State::error_of(int code, std::string_view what) const {
  const auto message = fmt::format("pool {}, model {}: {}: {}", options.pool, options.model, what,
                                   std::generic_category().message(-code));
  if (code == -ENOSPC || code == -EDQUOT) return {ErrorCode::kNoSpace, message};
  if (code == -EIO) return {ErrorCode::kCorrupt, message};  // The cluster's own checksums.
  return {ErrorCode::kIo, message};
}

}  // namespace voxatlas
