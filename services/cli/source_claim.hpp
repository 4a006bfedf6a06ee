#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bus/convert_scan.hpp"
#include "cli/model_client.hpp"

namespace voxatlas {

/// The right to be a source's only publisher, kept as long as it is pumped, and an eye on its
/// marks.
///
/// Source:  lcmtypes/README.md, "One publisher a source".
/// Errors:  take: kUnavailable where another process holds the source for longer than a claim
/// lasts.
///          pump: the same where another took it over while shard 0 was away; kCorrupt where a
///          shard has lost scans that it had acknowledged.
/// Threads: one at a time.
class SourceClaim {
 public:
  static constexpr std::int64_t kEveryUs = 500'000;
  static constexpr std::int64_t kPatienceUs = 3'000'000;  ///< A claim that lapses does so sooner.

  /// Waits where another holds the source. `client` must outlive it.
  static Result<std::unique_ptr<SourceClaim>> take(ModelClient& client, const std::string& source,
                                                   std::int64_t session);
  ~SourceClaim();

  /// Renews when it is time, at every shard. Every scan below `acked_below` is acknowledged.
  Status pump(std::int64_t now, std::int64_t acked_below);
  std::int64_t next_poll() const { return next_; }

 private:
  SourceClaim(ModelClient& client, const std::string& source, std::int64_t session);
  model_request_t request(std::int32_t shard) const;
  void on_reply(const model_reply_t& reply);
  Status renew(std::int64_t now, std::int64_t acked_below);

  ModelClient& client_;
  std::string source_;
  std::int64_t session_;
  Bus::Subscription replies_ = 0;
  std::int64_t next_ = 0;
  std::int64_t id_ = 0;           ///< Of the last round of questions,
  std::int64_t acked_below_ = 0;  ///< and what was told in it.
  std::optional<Error> trouble_;  ///< Found in an answer.
};

}  // namespace voxatlas
