#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <deque>
#include <iterator>

#include "base/check.hpp"
#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/checkpoint_wire.hpp"
#include "bus/credit.hpp"
#include "bus/requests.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kRetryUs = 100'000;
constexpr std::int64_t kRetryMaxUs = 1'000'000;
constexpr std::int64_t kMostAtOnce = 64;
constexpr std::size_t kReplyBytes = 60'000;

/// When a question goes out, and when again.
class Retry {
 public:
  bool due(std::int64_t now) {
    if (now < next_) return false;
    next_ = now + interval_;
    interval_ = std::min(2 * interval_, kRetryMaxUs);
    return true;
  }
  std::int64_t next() const { return next_; }

 private:
  std::int64_t next_ = 0;
  std::int64_t interval_ = kRetryUs;
};

/// A tile on its way, range by range.
struct Fetch {
  std::int32_t shard;
  StoreClient::FetchedTile tile;
  bool begun = false;      ///< Its version and size are known.
  std::int32_t total = 0;  ///< Bytes of the whole tile.
  Retry retry{};
};

/// Takes a range in. A tile whose version or size changes under way begins again.
void take_range(Fetch& fetch, const tile_reply_t& reply) {
  auto& tile = fetch.tile;
  const bool goes_on = fetch.begun && reply.version == tile.version && reply.total == fetch.total &&
                       static_cast<std::size_t>(reply.offset) == tile.bytes.size();
  if (!goes_on) tile.bytes.clear();
  fetch.begun = goes_on || reply.offset == 0;
  fetch.retry = Retry();
  if (!fetch.begun) return;
  tile.version = reply.version;
  fetch.total = reply.total;
  tile.bytes.insert(tile.bytes.end(), reply.payload.begin(), reply.payload.end());
}

bool is_whole(const Fetch& fetch) {
  return fetch.begun && fetch.tile.bytes.size() == static_cast<std::size_t>(fetch.total);
}

}  // namespace

struct StoreClient::State {
  State(Bus& b, Bus& p, const Endpoint& s) : bus(b), port(p), reply_port(s.port_offset()) {}

  template <class Reply>
  void listen(const char* channel, std::map<std::int64_t, std::optional<Reply>>& answers) {
    subscriptions.push_back(port.subscribe<Reply>(channel, [this, &answers](const Reply& reply) {
      const auto asked = answers.find(reply.id);
      if (reply.client == client && asked != answers.end()) asked->second = reply;
    }));
  }

  template <class Request, class Reply>
  Result<Reply> ask(const char* channel, Request request,
                    std::map<std::int64_t, std::optional<Reply>>& answers, std::int64_t timeout_us);
  template <class Request>
  Status send(const char* channel, Request& request, std::int64_t deadline);
  Status wait(std::int64_t until);

  Status ask_for(Fetch& fetch, int depth, std::int64_t id, std::int64_t deadline);

  Bus& bus;
  Bus& port;
  std::int32_t reply_port;
  std::int64_t client = random_id();
  std::int64_t last_id = 0;
  std::vector<Bus::Subscription> subscriptions;
  std::map<std::int64_t, std::optional<model_reply_t>> models;  ///< By id, those asked for.
  std::map<std::int64_t, std::optional<checkpoint_reply_t>> checkpoints;
  std::map<std::int64_t, std::optional<tiles_reply_t>> pages;
  std::map<std::int64_t, std::optional<tile_reply_t>> tiles;
};

/// Runs handlers until something has come or the time is up.
Status StoreClient::State::wait(std::int64_t until) {
  const auto wait_us = std::max<std::int64_t>(0, until - steady_utime());
  pollfd fds[] = {{bus.fd(), POLLIN, 0}, {port.fd(), POLLIN, 0}};
  ::poll(fds, 2, static_cast<int>(std::min<std::int64_t>(100, (wait_us + 999) / 1000)));
  if (auto handled = port.handle_waiting(); !handled || &bus == &port) return handled;
  return bus.handle_waiting();
}

template <class Request>
Status StoreClient::State::send(const char* channel, Request& request, std::int64_t deadline) {
  request.utime = utime_now();
  request.deadline = request.utime + (deadline - steady_utime());
  auto sent = bus.publish(channel, request);
  // While the hub is away a question is lost like any other: it is asked again.
  if (!sent && sent.error().code == ErrorCode::kUnavailable) return {};
  return sent;
}

template <class Request, class Reply>
Result<Reply> StoreClient::State::ask(const char* channel, Request request,
                                      std::map<std::int64_t, std::optional<Reply>>& answers,
                                      std::int64_t timeout_us) {
  request.client = client;
  request.id = ++last_id;
  request.reply_port = reply_port;
  const auto deadline = steady_utime() + timeout_us;
  const auto answer = answers.emplace(request.id, std::nullopt).first;
  Retry retry;
  Status status;
  for (auto now = steady_utime(); status && !answer->second && now < deadline;
       now = steady_utime()) {
    if (retry.due(now)) status = send(channel, request, deadline);
    if (status) status = wait(std::min(deadline, retry.next()));
  }
  const auto reply = std::move(answer->second);
  answers.erase(answer);
  if (!status) return pass_on(status);
  if (!reply) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("tilestore {} has not answered {} within {:.1f} s", request.shard,
                            channel, static_cast<double>(timeout_us) / 1e6));
  }
  return std::move(*reply);
}

Status StoreClient::State::ask_for(Fetch& fetch, int depth, std::int64_t id,
                                   std::int64_t deadline) {
  tile_request_t request{};
  request.client = client;
  request.id = id;
  request.reply_port = reply_port;
  request.shard = fetch.shard;
  request.tile = fetch.tile.tile;
  request.offset = static_cast<std::int32_t>(fetch.tile.bytes.size());
  request.depth = static_cast<std::int8_t>(depth);
  return send(kTileRequestChannel, request, deadline);
}

StoreClient::StoreClient(Bus& bus, Bus& port, const Endpoint& self)
    : state_(std::make_unique<State>(bus, port, self)) {
  state_->listen(kModelReplyChannel, state_->models);
  state_->listen(kCheckpointReplyChannel, state_->checkpoints);
  state_->listen(kTilesReplyChannel, state_->pages);
  state_->listen(kTileReplyChannel, state_->tiles);
}

StoreClient::~StoreClient() {
  for (const auto subscription : state_->subscriptions) state_->port.unsubscribe(subscription);
}

std::int64_t StoreClient::client() const { return state_->client; }

Result<model_reply_t> StoreClient::model(std::int32_t shard, const std::string& source,
                                         std::int64_t session, std::int64_t timeout_us) {
  model_request_t request{};
  request.shard = shard;
  request.source = source;
  request.session = session;
  return model(std::move(request), timeout_us);
}

Result<model_reply_t> StoreClient::model(model_request_t request, std::int64_t timeout_us) {
  return state_->ask(kModelRequestChannel, std::move(request), state_->models, timeout_us);
}

Result<std::string> StoreClient::checkpoint(std::int32_t shard, std::int64_t timeout_us) {
  checkpoint_request_t request{};
  request.shard = shard;
  auto reply = state_->ask(kCheckpointRequestChannel, request, state_->checkpoints, timeout_us);
  if (!reply) return pass_on(reply);
  if (reply->error.empty()) return reply->folder;
  return fail(ErrorCode::kIo, fmt::format("tilestore {}: {}", shard, reply->error));
}

Result<tiles_reply_t> StoreClient::tiles(tiles_request_t request, std::int64_t timeout_us) {
  return state_->ask(kTilesRequestChannel, std::move(request), state_->pages, timeout_us);
}

Status StoreClient::fetch(const std::vector<std::pair<std::int32_t, std::int64_t>>& shard_and_tile,
                          std::int64_t timeout_us, const std::function<void(FetchedTile)>& arrived,
                          int depth) {
  auto& state = *state_;
  auto buffer = receive_buffer_of(state.port.url());
  if (!buffer) return pass_on(buffer);
  const auto at_once = static_cast<std::size_t>(std::clamp<std::int64_t>(
      static_cast<std::int64_t>(*buffer / buffer_cost(kReplyBytes)), 1, kMostAtOnce));
  auto deadline = steady_utime() + timeout_us;
  std::map<std::int64_t, Fetch> under_way;  // By the id of its last question.
  std::size_t begun = 0;
  Status status;
  while (status && steady_utime() < deadline &&
         (begun < shard_and_tile.size() || !under_way.empty())) {
    while (begun < shard_and_tile.size() && under_way.size() < at_once) {
      const auto& [shard, key] = shard_and_tile[begun++];
      under_way.emplace(++state.last_id, Fetch{shard, {key, 0, {}}});
    }
    auto wake = deadline;
    for (auto& [id, fetch] : under_way) {
      state.tiles.try_emplace(id);
      if (status && fetch.retry.due(steady_utime())) {
        status = state.ask_for(fetch, depth, id, deadline);
      }
      wake = std::min(wake, fetch.retry.next());
    }
    if (status) status = state.wait(wake);
    for (auto it = state.tiles.begin(); it != state.tiles.end();) {
      if (!it->second) {
        ++it;
        continue;
      }
      auto fetch = std::move(under_way.extract(it->first).mapped());
      const auto reply = std::move(*it->second);
      it = state.tiles.erase(it);
      if (reply.tile == fetch.tile.tile) take_range(fetch, reply);
      if (is_whole(fetch)) {
        deadline = steady_utime() + timeout_us;
        arrived(std::move(fetch.tile));
      } else {
        under_way.emplace(++state.last_id, std::move(fetch));
      }
    }
  }
  state.tiles.clear();
  if (!status) return status;
  const auto missing = under_way.size() + shard_and_tile.size() - begun;
  if (missing == 0) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("{} of {} tiles are missing: none came for {:.1f} s", missing,
                          shard_and_tile.size(), static_cast<double>(timeout_us) / 1e6));
}

}  // namespace voxatlas
