#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "store/tile_store.hpp"

namespace voxatlas {

/// Keys and values as FORMAT.md states them, and the words every backend uses for its errors.
/// For the backends of this folder; nobody else includes it.

/// 4 bytes of shard, then 8 bytes of Morton code or journal position, big endian: byte order is
/// order of numbers.
std::string shard_prefix(ShardId shard);
std::string row_key(ShardId shard, std::uint64_t number);
/// A named thing of a shard: the prefix, then the name.
std::string name_key(ShardId shard, std::string_view name);
/// The number of a key that row_key made. Errors: kCorrupt for another length.
Result<std::uint64_t> row_number(std::string_view key);

/// A value with its checksum in front: CRC-32C over key and body, so that a value under a wrong
/// key is detected too.
std::string seal(std::string_view key, ByteView body);
/// The body, a view into `sealed`. Errors: kCorrupt; the message begins with `what`.
Result<ByteView> unseal(std::string_view key, std::string_view sealed, const std::string& what);

std::string seal_tile(std::string_view key, const StoredTile& tile);
Result<StoredTile> unseal_tile(std::string_view key, std::string_view sealed);

Bytes encode_marks(std::span<const Mark> marks);
Result<std::vector<Mark>> decode_marks(ByteView bytes);

/// kFenced: who owns the shard, and who wanted to write.
tl::unexpected<Error> fenced(ShardId shard, Epoch mine, Epoch owner);
/// kInvalid: records that were never appended cannot be forgotten.
tl::unexpected<Error> trim_beyond(ShardId shard, JournalPosition position, JournalPosition last);

}  // namespace voxatlas
