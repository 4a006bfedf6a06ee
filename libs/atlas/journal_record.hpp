#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/tile_key.hpp"

namespace voxatlas {

/// One delta of a record: the version it produces, and encode_delta's bytes, which are borrowed.
struct JournalDelta {
  TileKey key;
  std::uint64_t version = 0;
  ByteView delta;
};

/// What the journal holds of one scan. Layout: FORMAT.md. The deltas' bytes are views into what was
/// decoded, or into what will be encoded.
struct JournalRecord {
  std::string source;
  std::int64_t session = 0;
  std::int64_t seq = 0;
  std::vector<JournalDelta> deltas;
};

Bytes encode_record(const JournalRecord& record);
/// Errors: kCorrupt; the deltas' own bytes are not looked into.
Result<JournalRecord> decode_record(ByteView bytes);

}  // namespace voxatlas
