#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/endpoint.hpp"

namespace voxatlas {

/// Asks tile stores, with correlation, deadline and retry: each question goes out again (100 ms,
/// doubling to 1 s) until its answer comes or its deadline passes. Blocking calls, for the command
/// line and for start-up; handlers of other subscriptions on the same connections run meanwhile.
///
/// Threads: one at a time.
class StoreClient {
 public:
  /// `bus` carries the questions; answers come at `self`'s own port, on `port`.
  StoreClient(Bus& bus, Bus& port, const Endpoint& self);
  ~StoreClient();

  std::int64_t client() const;  ///< Random, in every question.

  /// Errors: kUnavailable where the shard does not answer before the time is over, naming it.
  Result<model_reply_t> model(std::int32_t shard, const std::string& source, std::int64_t session,
                              std::int64_t timeout_us);
  Result<model_reply_t> model(model_request_t request, std::int64_t timeout_us);
  Result<tiles_reply_t> tiles(tiles_request_t request, std::int64_t timeout_us);

  /// A copy of the shard, made now. Returns its folder's name within the model's folder.
  /// Errors: also the shard's own, in its words (kIo).
  Result<std::string> checkpoint(std::int32_t shard, std::int64_t timeout_us);

  struct FetchedTile {
    std::int64_t tile = 0;
    std::int64_t version = 0;  ///< 0: never written; bytes is empty then.
    Bytes bytes;               ///< encode_tile's.
  };
  /// Fetches many tiles, several questions under way at once (bounded by the receive buffer),
  /// `arrived` called for each as it completes. `depth`: 7 the tiles as they are, 0..6 cut there,
  /// which takes fewer bytes. `timeout_us`: where no tile came for so long, that is the end.
  /// Errors: kUnavailable if some did not come; those that did have been handed over.
  Status fetch(const std::vector<std::pair<std::int32_t, std::int64_t>>& shard_and_tile,
               std::int64_t timeout_us, const std::function<void(FetchedTile)>& arrived,
               int depth = 7);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Answers a request at the port it names: keeps the connections to clients' ports, at most 64.
class ReplyPorts {
 public:
  explicit ReplyPorts(Bus& bus);
  ~ReplyPorts();

  /// The connection for a request's reply_port. Errors: kOutOfRange for one that is no client's.
  Result<Bus*> at(std::int32_t reply_port);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// 63 random bits, never 0: sessions, clients, incarnations.
std::int64_t random_id();

}  // namespace voxatlas
