#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/convert_scan.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// Puts plain scans (VOXATLAS_SCAN) together from their parts and gives each whole one the ingest's
/// own gapless identity, under which it is as reliable as any.
///
/// Source: DESIGN section 6. Ingest number hash(source) mod ingests takes all parts of a source.
/// Time:   steady microseconds. A scan not whole within kPatience is dropped and counted.
/// Memory: at most kMaxOpen scans of kMaxScanBytes each; the oldest is dropped for a newer one.
/// Threads: one at a time.
class PlainScans {
 public:
  static constexpr std::int64_t kPatience = 500'000;
  static constexpr std::size_t kMaxOpen = 32;
  static constexpr std::int16_t kMaxParts = 64;
  static constexpr std::size_t kMaxSources = 1024;  ///< More are refused: a source costs memory.

  /// `session` becomes that of the scans handed out: random, one run of this ingest.
  PlainScans(std::int32_t ingest, std::int32_t ingests, std::int64_t session);

  /// True where this ingest, of all, takes the source's plain scans.
  bool is_ours(const std::string& source) const;

  /// Takes one part; returns the scan, still under the logger's identity, where it was the last one
  /// missing.
  /// Errors: kCorrupt or kOutOfRange for a part that contradicts itself or the parts before.
  Result<std::optional<scan_t>> offer(const scan_t& part, std::int64_t now);

  /// Gives a whole scan that is about to be integrated its place: the source is the logger's with
  /// "~plain" behind it, so that it can never meet a reliable source's numbers. What is dropped
  /// before this leaves no gap.
  void adopt(scan_t& whole);

  /// Drops what has waited too long.
  void expire(std::int64_t now);

  struct Counters {
    std::uint64_t parts = 0, whole = 0;
    std::uint64_t incomplete = 0;  ///< Dropped: not whole in time, or pushed out.
    std::uint64_t repeated = 0;    ///< Parts of scans that were whole already, or long past.
    std::uint64_t gaps = 0;        ///< Scans missing between whole ones of a session.
  };
  const Counters& counters() const { return counters_; }

 private:
  struct Open {
    std::int64_t since = 0;
    std::vector<std::optional<scan_t>> parts;
    std::size_t missing = 0;
  };
  /// The newest scan of a logger's session and which of the 64 up to it were whole (bit 0: newest).
  struct Seen {
    std::int64_t newest = -1;
    std::uint64_t whole = 0;
  };
  Status check(const scan_t& part, const ScanIdentity& identity) const;
  Open& open_for(const ScanIdentity& identity, std::int16_t parts, std::int64_t now);
  bool was_whole(const ScanIdentity& identity) const;
  void note_whole(const ScanIdentity& identity);
  static scan_t join(const Open& open);

  std::int32_t ingest_;
  std::int32_t ingests_;
  std::int64_t session_;
  std::map<ScanIdentity, Open> open_;
  std::map<std::string, std::int64_t> next_seq_;  ///< Ours, by source.
  std::map<std::pair<std::string, std::int64_t>, Seen> seen_;
  Counters counters_;
};

}  // namespace voxatlas
