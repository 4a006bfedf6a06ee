#pragma once

#include <cstdint>
#include <vector>

#include "bus/bus.hpp"
#include "bus/reply_cache.hpp"
#include "bus/requests.hpp"
#include "bus/status_counters.hpp"
#include "tilestore/question_budget.hpp"
#include "tilestore/tile_queries.hpp"

namespace voxatlas {

/// A shard's questions on the bus: hears them and sends the answers to who asked.
///
/// Not answered: what is for another shard, what nobody waits for any more (its deadline is over),
///          what cannot be (counted, logged), and what the budget has no time for.
/// Again:   a question that comes twice gets the answer that was made the first time.
/// Threads: one at a time; works inside the bus's handle_waiting().
class QuestionDesk {
 public:
  /// `bus` and `queries` must outlive it.
  QuestionDesk(Bus& bus, TileQueries& queries, std::int32_t shard);
  ~QuestionDesk();
  QuestionDesk(const QuestionDesk&) = delete;
  QuestionDesk& operator=(const QuestionDesk&) = delete;

  /// The import goes on: questions get their share of the time, no more.
  void delta_came(std::int64_t now) { budget_.delta_came(now); }
  void add_to(StatusCounters& counters) const;

 private:
  template <class Request>
  void listen(const char* request_channel, const char* reply_channel);
  template <class Request>
  Status answer(const Request& request, const char* reply_channel);

  Bus& bus_;
  TileQueries& queries_;
  std::int32_t shard_;
  ReplyPorts ports_;
  ReplyCache replies_;
  QuestionBudget budget_;
  std::vector<Bus::Subscription> subscriptions_;
  std::uint64_t bad_ = 0, again_ = 0, put_off_ = 0;
};

}  // namespace voxatlas
