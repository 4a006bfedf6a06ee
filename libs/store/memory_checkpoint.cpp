#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/crc32c.hpp"
#include "store/memory_store.hpp"
#include "store/store_format.hpp"

namespace voxatlas {

static constexpr std::string_view kMagic = "VOXMEM01";

void MemoryStore::write(const Shard& shard, Bytes& out) {
  ByteWriter writer(out);
  writer.put(shard.epoch);
  writer.put(shard.last);
  writer.put_varint(shard.journal.size());
  for (const auto& [position, record] : shard.journal) {
    writer.put(position);
    writer.put_string(as_text(record));
  }
  writer.put_varint(shard.tiles.size());
  for (const auto& [key, tile] : shard.tiles) {
    writer.put(key.morton());
    writer.put(tile.version);
    writer.put_string(as_text(tile.bytes));
  }
  writer.put_string(as_text(encode_marks(shard.marks)));
  writer.put_varint(shard.values.size());
  for (const auto& [name, value] : shard.values) {
    writer.put_string(name);
    writer.put_string(as_text(value));
  }
}

static Bytes get_bytes(ByteReader& reader) {
  const ByteView bytes = reader.get_bytes(reader.get_varint());
  return {bytes.begin(), bytes.end()};
}

Result<MemoryStore::Shard> MemoryStore::read(ByteView bytes) {
  ByteReader reader(bytes);
  Shard shard;
  shard.epoch = reader.get<Epoch>();
  shard.last = reader.get<JournalPosition>();
  for (auto count = reader.get_varint(); count > 0 && reader.ok(); --count) {
    const auto position = reader.get<JournalPosition>();
    shard.journal.emplace(position, get_bytes(reader));
  }
  for (auto count = reader.get_varint(); count > 0 && reader.ok(); --count) {
    auto key = TileKey::from_morton(reader.get<std::uint64_t>());
    if (!key) return pass_on(key, "memory store's checkpoint");
    const auto version = reader.get<std::uint64_t>();
    shard.tiles.emplace(*key, StoredTile{*key, version, get_bytes(reader)});
  }
  auto marks = decode_marks(get_bytes(reader));
  if (!marks) return pass_on(marks, "memory store's checkpoint");
  shard.marks = std::move(*marks);
  for (auto count = reader.get_varint(); count > 0 && reader.ok(); --count) {
    auto name = reader.get_string();
    shard.values.emplace(std::move(name), get_bytes(reader));
  }
  if (!reader.at_end()) {
    return fail(ErrorCode::kCorrupt, "memory store's checkpoint: a shard ends elsewhere than said");
  }
  return shard;
}

Status MemoryStore::checkpoint(const std::string& directory) {
  const std::lock_guard lock(mutex_);
  Bytes out;
  ByteWriter writer(out);
  writer.put_bytes(as_bytes(kMagic));
  writer.put_varint(shards_.size());
  for (const auto& [id, shard] : shards_) {
    Bytes bytes;
    write(shard, bytes);
    writer.put(id);
    writer.put_string(as_text(bytes));
  }
  writer.put(crc32c(out));
  std::error_code error;
  if (!std::filesystem::create_directory(directory, error)) {
    return fail(ErrorCode::kIo, fmt::format("checkpoint: cannot make the folder {}: {}", directory,
                                            error ? error.message() : "it exists"));
  }
  std::ofstream file(directory + "/memory_store", std::ios::binary);
  file.write(as_text(out).data(), static_cast<std::streamsize>(out.size()));
  file.close();
  if (!file) return fail(ErrorCode::kIo, "checkpoint: cannot write " + directory + "/memory_store");
  return {};
}

Result<std::unique_ptr<MemoryStore>> MemoryStore::load(const std::string& directory) {
  const std::string path = directory + "/memory_store";
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kIo, "cannot open " + path);
  const Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t body = bytes.size() < 4 ? 0 : bytes.size() - 4;
  ByteReader check(ByteView(bytes).subspan(body));
  ByteReader reader(ByteView(bytes).first(body));
  if (check.get<std::uint32_t>() != crc32c(ByteView(bytes).first(body)) ||
      as_text(reader.get_bytes(kMagic.size())) != kMagic) {
    return fail(ErrorCode::kCorrupt, path + " is damaged or no checkpoint of a memory store");
  }
  auto store = std::make_unique<MemoryStore>();
  for (auto count = reader.get_varint(); count > 0 && reader.ok(); --count) {
    const auto id = reader.get<ShardId>();
    auto shard = read(get_bytes(reader));
    if (!shard) return pass_on(shard, path);
    store->shards_.emplace(id, std::move(*shard));
  }
  if (!reader.at_end()) return fail(ErrorCode::kCorrupt, path + " ends elsewhere than it says");
  return store;
}

}  // namespace voxatlas
