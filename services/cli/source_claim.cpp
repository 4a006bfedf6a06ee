#include "cli/source_claim.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"

namespace voxatlas {

static constexpr std::int64_t kAgainUs = 100'000;

SourceClaim::SourceClaim(ModelClient& client, const std::string& source, std::int64_t session)
    : client_(client), source_(source), session_(session) {
  replies_ = client_.in().port().subscribe<model_reply_t>(
      kModelReplyChannel, [this](const model_reply_t& reply) { on_reply(reply); });
}

/// Should giving it back get lost, it lapses.
SourceClaim::~SourceClaim() {
  client_.in().port().unsubscribe(replies_);
  auto back = request(0);
  back.claim = 2;
  (void)client_.bus().publish(kModelRequestChannel, back);
}

model_request_t SourceClaim::request(std::int32_t shard) const {
  model_request_t request{};
  request.shard = shard;
  request.source = source_;
  request.session = session_;
  request.claim = 1;
  request.utime = utime_now();
  request.deadline = request.utime + kEveryUs;
  request.client = client_.stores().client();
  request.reply_port = client_.port_offset();
  return request;
}

Result<std::unique_ptr<SourceClaim>> SourceClaim::take(ModelClient& client,
                                                       const std::string& source,
                                                       std::int64_t session) {
  std::unique_ptr<SourceClaim> claim(new SourceClaim(client, source, session));
  const auto end = steady_utime() + kPatienceUs;
  for (;;) {
    auto reply = client.stores().model(claim->request(0), ModelClient::kPatience);
    if (!reply) return pass_on(reply);
    if (reply->holder == client.stores().client()) return claim;
    if (stop_requested()) return fail(ErrorCode::kUnavailable, "stopped before it began");
    if (steady_utime() < end) {
      std::this_thread::sleep_for(std::chrono::microseconds(kAgainUs));
      continue;
    }
    return fail(ErrorCode::kUnavailable,
                fmt::format("source \"{}\" is being published by another process, and scans of one "
                            "source come from one publisher: stop that one, or give this one a "
                            "--source of its own",
                            source));
  }
}

void SourceClaim::on_reply(const model_reply_t& reply) {
  if (reply.client != client_.stores().client() || reply.id != id_ || trouble_) return;
  if (reply.shard == 0 && reply.holder != client_.stores().client()) {
    trouble_ =
        Error{ErrorCode::kUnavailable,
              fmt::format("source \"{}\" was taken over by another publisher while tilestore "
                          "0 was away; the same command goes on when that one has ended",
                          source_)};
  }
  if (reply.mark >= acked_below_ - 1) return;
  trouble_ = Error{
      ErrorCode::kCorrupt,
      fmt::format(
          "tilestore {} has lost scans of {} that it had acknowledged: all below {} were, and "
          "it has them up to {}",
          reply.shard, source_, acked_below_, reply.mark)};
}

Status SourceClaim::pump(std::int64_t now, std::int64_t acked_below) {
  if (trouble_) return tl::unexpected<Error>(*trouble_);
  return now < next_ ? Status{} : renew(now, acked_below);
}

Status SourceClaim::renew(std::int64_t now, std::int64_t acked_below) {
  next_ = now + kEveryUs;
  id_ = random_id();
  acked_below_ = acked_below;
  const auto shards = static_cast<std::int32_t>(client_.parameters().shards);
  for (std::int32_t shard = 0; shard < shards; ++shard) {
    auto renewal = request(shard);
    renewal.id = id_;
    renewal.acked_below = acked_below;
    auto sent = client_.bus().publish(kModelRequestChannel, renewal);
    if (!sent && sent.error().code != ErrorCode::kUnavailable) return sent;  // The hub comes back.
  }
  return {};
}

}  // namespace voxatlas
