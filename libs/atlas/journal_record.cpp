#include "atlas/journal_record.hpp"

#include <fmt/format.h>

namespace voxatlas {

/// The kinds of change a journal can hold; one so far.
static constexpr std::uint8_t kScanKind = 1;

Bytes encode_record(const JournalRecord& record) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put(kScanKind);
  out.put_string(record.source);
  out.put(record.session);
  out.put(record.seq);
  out.put_varint(record.deltas.size());
  for (const auto& delta : record.deltas) {
    out.put(delta.key.morton());
    out.put_varint(delta.version);
    out.put_string(as_text(delta.delta));
  }
  return bytes;
}

Result<JournalRecord> decode_record(ByteView bytes) {
  ByteReader in(bytes);
  const auto kind = in.get<std::uint8_t>();
  if (kind != kScanKind) {
    return fail(ErrorCode::kCorrupt, fmt::format("journal record of kind {}, not 1", kind));
  }
  JournalRecord record;
  record.source = in.get_string();
  record.session = in.get<std::int64_t>();
  record.seq = in.get<std::int64_t>();
  for (auto count = in.get_varint(); count > 0 && in.ok(); --count) {
    auto key = TileKey::from_morton(in.get<std::uint64_t>());
    if (!key) return fail(ErrorCode::kCorrupt, "journal record: " + key.error().message);
    const auto version = in.get_varint();
    record.deltas.push_back({*key, version, in.get_bytes(in.get_varint())});
  }
  if (!in.at_end()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("journal record: {} bytes do not parse", bytes.size()));
  }
  return record;
}

}  // namespace voxatlas
