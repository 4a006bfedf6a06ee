#include "tilestore/question_desk.hpp"

#include <type_traits>

#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"

namespace voxatlas {

namespace {

/// Answers kept for those who ask again: of ten seconds, as long as anyone's patience.
constexpr std::size_t kRepliesBytes = std::size_t{1} << 20;
constexpr std::int64_t kRepliesUs = 10'000'000;

}  // namespace

/// A claim would lapse where it had to wait for others' questions.
template <class Request>
static bool may_wait(const Request& request) {
  if constexpr (std::is_same_v<Request, model_request_t>) return request.claim == 0;
  return true;
}

QuestionDesk::QuestionDesk(Bus& bus, TileQueries& queries, std::int32_t shard)
    : bus_(bus),
      queries_(queries),
      shard_(shard),
      ports_(bus),
      replies_(kRepliesBytes, kRepliesUs) {
  listen<model_request_t>(kModelRequestChannel, kModelReplyChannel);
  listen<tiles_request_t>(kTilesRequestChannel, kTilesReplyChannel);
  listen<tile_request_t>(kTileRequestChannel, kTileReplyChannel);
}

QuestionDesk::~QuestionDesk() {
  for (const auto subscription : subscriptions_) bus_.unsubscribe(subscription);
}

template <class Request>
void QuestionDesk::listen(const char* request_channel, const char* reply_channel) {
  subscriptions_.push_back(
      bus_.subscribe<Request>(request_channel, [this, reply_channel](const Request& request) {
        if (request.shard != shard_ || request.deadline < utime_now()) return;
        if (auto sent = answer(request, reply_channel); !sent) {
          ++bad_;
          log_warning("{} of client {} not answered: {}", Request::getTypeName(), request.client,
                      sent.error().message);
        }
      }));
}

template <class Request>
Status QuestionDesk::answer(const Request& request, const char* reply_channel) {
  auto port = ports_.at(request.reply_port);
  if (!port) return pass_on(port);
  const auto now = steady_utime();
  const ReplyCache::Question question{Request::getHash(), request.client, request.id};
  if (const Bytes* given = replies_.find(question, now)) {
    ++again_;
    return (*port)->publish_bytes(reply_channel, *given);
  }
  if (may_wait(request) && !budget_.allows(now)) {
    ++put_off_;
    return {};
  }
  auto made = queries_.answer(request);
  budget_.spend(steady_utime() - now);
  if (!made) return pass_on(made);
  auto bytes = encode_message(*made);
  auto sent = (*port)->publish_bytes(reply_channel, bytes);
  replies_.keep(question, std::move(bytes), now);
  return sent;
}

void QuestionDesk::add_to(StatusCounters& counters) const {
  counters.emplace_back("bad_requests", static_cast<double>(bad_));
  counters.emplace_back("answered_again", static_cast<double>(again_));
  counters.emplace_back("questions_put_off", static_cast<double>(put_off_));
}

}  // namespace voxatlas
