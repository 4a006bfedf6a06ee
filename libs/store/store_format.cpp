#include "store/store_format.hpp"

#include <fmt/format.h>

#include "base/crc32c.hpp"

namespace voxatlas {

static constexpr std::size_t kPrefixBytes = 4;
static constexpr std::size_t kRowKeyBytes = kPrefixBytes + 8;

static void put_big_endian(std::uint64_t number, unsigned bytes, std::string& out) {
  while (bytes-- > 0) out.push_back(static_cast<char>(number >> 8 * bytes & 0xff));
}

std::string shard_prefix(ShardId shard) {
  std::string key;
  put_big_endian(shard, 4, key);
  return key;
}

std::string row_key(ShardId shard, std::uint64_t number) {
  std::string key = shard_prefix(shard);
  put_big_endian(number, 8, key);
  return key;
}

std::string name_key(ShardId shard, std::string_view name) {
  return shard_prefix(shard).append(name);
}

Result<std::uint64_t> row_number(std::string_view key) {
  if (key.size() != kRowKeyBytes) {
    return fail(ErrorCode::kCorrupt, fmt::format("a key of {} bytes, not 12", key.size()));
  }
  std::uint64_t number = 0;
  for (const char c : key.substr(kPrefixBytes)) number = number << 8 | static_cast<std::uint8_t>(c);
  return number;
}

std::string seal(std::string_view key, ByteView body) {
  const std::uint32_t sum = crc32c(body, crc32c(as_bytes(key)));
  std::string sealed(sizeof sum + body.size(), '\0');
  std::memcpy(sealed.data(), &sum, sizeof sum);
  if (!body.empty()) std::memcpy(sealed.data() + sizeof sum, body.data(), body.size());
  return sealed;
}

Result<ByteView> unseal(std::string_view key, std::string_view sealed, const std::string& what) {
  ByteReader reader(as_bytes(sealed));
  const auto sum = reader.get<std::uint32_t>();
  const ByteView body = reader.get_bytes(reader.remaining());
  if (!reader.ok() || sum != crc32c(body, crc32c(as_bytes(key)))) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{}: checksum of {} stored bytes is wrong", what, sealed.size()));
  }
  return body;
}

std::string seal_tile(std::string_view key, const StoredTile& tile) {
  Bytes body;
  body.reserve(sizeof tile.version + tile.bytes.size());
  ByteWriter writer(body);
  writer.put(tile.version);
  writer.put_bytes(tile.bytes);
  return seal(key, body);
}

Result<StoredTile> unseal_tile(std::string_view key, std::string_view sealed) {
  auto code = row_number(key);
  if (!code) return pass_on(code, "tile");
  auto tile = TileKey::from_morton(*code);
  if (!tile) return fail(ErrorCode::kCorrupt, "tile: " + tile.error().message);
  auto body = unseal(key, sealed, fmt::format("tile {:#x}", *code));
  if (!body) return pass_on(body);
  ByteReader reader(*body);
  const auto version = reader.get<std::uint64_t>();
  const ByteView bytes = reader.get_bytes(reader.remaining());
  if (!reader.ok()) return fail(ErrorCode::kCorrupt, fmt::format("tile {:#x}: no version", *code));
  return StoredTile{*tile, version, Bytes(bytes.begin(), bytes.end())};
}

Bytes encode_marks(std::span<const Mark> marks) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put_varint(marks.size());
  for (const auto& mark : marks) {
    writer.put_string(mark.source);
    writer.put(mark.session);
    writer.put(mark.seq);
  }
  return bytes;
}

Result<std::vector<Mark>> decode_marks(ByteView bytes) {
  ByteReader reader(bytes);
  std::vector<Mark> marks;
  for (auto count = reader.get_varint(); count > 0 && reader.ok(); --count) {
    Mark mark;
    mark.source = reader.get_string();
    mark.session = reader.get<std::int64_t>();
    mark.seq = reader.get<std::int64_t>();
    marks.push_back(std::move(mark));
  }
  if (!reader.at_end()) {
    return fail(ErrorCode::kCorrupt, fmt::format("marks: {} bytes do not parse", bytes.size()));
  }
  return marks;
}

tl::unexpected<Error> fenced(ShardId shard, Epoch mine, Epoch owner) {
  return fail(ErrorCode::kFenced,
              fmt::format("shard {} belongs to epoch {} now, not to {}", shard, owner, mine));
}

tl::unexpected<Error> trim_beyond(ShardId shard, JournalPosition position, JournalPosition last) {
  return fail(
      ErrorCode::kInvalid,
      fmt::format("shard {}: cannot trim to {}, the journal ends at {}", shard, position, last));
}

}  // namespace voxatlas
