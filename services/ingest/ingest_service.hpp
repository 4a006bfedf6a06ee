#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "bus/convert_scan.hpp"
#include "bus/message_kind.hpp"
#include "bus/status_counters.hpp"
#include "bus/wire.hpp"
#include "ingest/integration_workers.hpp"

namespace voxatlas {

/// A message of a reliable stream, for acknowledging it later. Session 0: a plain scan, nobody
/// waits.
struct StreamRef {
  std::int64_t session = 0;
  std::int64_t number = 0;
};

/// What an ingest does with scans, without a network: scans in, one scan_delta_t a shard out.
///
/// Source:  DESIGN sections 4 and 6. Every scan gives every shard exactly one message, empty where
/// it
///          touched nothing there or was refused. A scan is done when every shard has committed its
///          message; then its publisher's stream may forget it.
/// Order:   deltas leave as workers finish them; shards put a source's scans in order.
/// Memory:  at most kMaxInFlight scans between take and finished(), and as many plain ones between
///          take and commit. A source's publisher leaves at most 64 scans uncommitted; no bound of
///          all sources together may keep one out, for it may be the very scan that the others
///          wait for in the shards.
/// Threads: one at a time; the integration runs on workers of its own.
class IngestService {
 public:
  static constexpr std::size_t kMaxInFlight = 64;

  IngestService(const ModelParameters& parameters, int workers);

  /// False: take no more scans for now, let the publishers wait.
  bool has_room() const { return integrating_ < kMaxInFlight; }
  /// The same for plain scans, whose loggers wait for nobody.
  bool has_room_for_plain() const { return has_room() && plain_in_flight_ < kMaxInFlight; }

  /// Takes a scan. One that cannot be integrated still becomes empty messages, counted and logged;
  /// one without an identity is dropped (counted, logged) and done at once.
  void take(const scan_t& message, StreamRef from);

  /// A reliable message as it came: a scan_t, or something nobody can use, which is dropped
  /// (counted, logged) and done at once, so that it does not block its stream.
  void take_message(MessageKind kind, ByteView payload, StreamRef from);

  /// One scan's messages, a shard each, for sending; `scan` names it in sent() and committed().
  struct Outgoing {
    std::uint64_t scan = 0;
    std::vector<scan_delta_t> shards;
  };
  std::vector<Outgoing> finished();

  /// Shard `shard` has this scan's message durably.
  void committed(std::uint64_t scan, std::int32_t shard);

  /// Up to which message each stream may be acknowledged, as far as that has moved: in the order of
  /// taking, because a stream's acknowledgement covers everything before it.
  std::vector<StreamRef> acknowledged();

  struct Counters {
    std::uint64_t scans = 0;         ///< Taken with an identity.
    std::uint64_t refused = 0;       ///< Of them: became empty messages.
    std::uint64_t unidentified = 0;  ///< Dropped.
    std::uint64_t acknowledged = 0;  ///< Durable in every shard.
    IntegrationCounts rays;
  };
  const Counters& counters() const { return counters_; }
  /// The newest scans acknowledged, by source; others may be missing where there are more ingests.
  const SourceMarks& marks() const { return marks_; }
  int fd() const { return workers_.fd(); }  ///< Readable when finished() has something: for poll().
  std::size_t in_flight() const { return in_flight_.size(); }

 private:
  struct InFlight {
    ScanIdentity identity;
    std::int64_t utime = 0;
    StreamRef from;
    std::vector<bool> committed;  ///< By shard.
    std::size_t waiting_for = 0;  ///< Shards that have not committed.
  };
  std::vector<scan_delta_t> split(const InFlight& scan, const ScanDelta& delta) const;
  std::int64_t acked_below(const ScanIdentity& identity) const;

  ModelParameters parameters_;
  std::int64_t parameters_id_;
  IntegrationWorkers workers_;
  std::uint64_t next_scan_ = 0;
  std::size_t integrating_ = 0;      ///< Taken, not finished().
  std::size_t plain_in_flight_ = 0;  ///< Of in_flight_.
  std::map<std::uint64_t, InFlight> in_flight_;
  std::map<std::int64_t, std::deque<std::pair<std::int64_t, std::uint64_t>>>
      streams_;  ///< By stream session: messages taken and not acknowledged, with their scan.
  std::map<std::pair<std::string, std::int64_t>, std::int64_t>
      acked_below_;  ///< Contiguous from seq 0, for the sources seen from their start.
  Counters counters_;
  SourceMarks marks_;
};

}  // namespace voxatlas
