#include "compress/compress_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"
#include "bus/stream_link.hpp"
#include "compress/compress_service.hpp"
#include "compress/machine_load.hpp"
#include "compress/open_tiles.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kLongestYield = 250'000;

class CompressProcess {
 public:
  explicit CompressProcess(const CompressOptions& options)
      : options_(options), service_(options.policy) {}

  Status start();
  Status run();

 private:
  Result<std::int64_t> work(std::int64_t now);
  bool may_work(std::int64_t now);
  void compress_one();
  StatusCounters counters() const;

  CompressOptions options_;
  CompressService service_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<InLink> in_;
  std::vector<std::unique_ptr<OutLink>> stores_;
  std::unique_ptr<StatusPublisher> status_;
  std::deque<StreamMessage> waiting_;
  OpenTiles open_;
  MachineLoad load_;
  double last_load_ = 0;
  std::int64_t yields_since_ = 0;  ///< Since when the next tile waits for others; 0: it does not.
  std::uint64_t yields_ = 0;
};

Status CompressProcess::start() {
  auto bus = Bus::create(options_.url);
  if (!bus) return pass_on(bus);
  bus_ = std::move(*bus);
  status_ = std::make_unique<StatusPublisher>(*bus_, "compress", options_.index);
  for (std::int32_t shard = 0; shard < options_.stores; ++shard) {
    auto store = Endpoint::create(EndpointClass::kStore, shard);
    if (!store) return pass_on(store);
    auto link = OutLink::create(*bus_, *store, StreamConfig{});
    if (!link) return pass_on(link);
    stores_.push_back(std::move(*link));
  }
  auto self = Endpoint::create(EndpointClass::kCompress, options_.index);
  if (!self) return pass_on(self);
  auto in = InLink::create(*bus_, *self, ConsumerConfig{});
  if (!in) return pass_on(in);
  in_ = std::move(*in);
  return {};
}

Status CompressProcess::run() {
  status_->set_state(true, "ready");
  log_info("ready");
  ServiceLoop loop;
  loop.buses = {bus_.get(), &in_->port()};
  loop.work = [this](std::int64_t now) { return work(now); };
  return loop.run();
}

/// Is there a tile, room for its result, and nothing that comes first?
bool CompressProcess::may_work(std::int64_t now) {
  const bool room =
      std::ranges::all_of(stores_, [](const auto& link) { return link->producer().has_room(); });
  if (waiting_.empty() || !room) return false;
  last_load_ = load_.now(now);
  if (last_load_ <= options_.max_load) {
    yields_since_ = 0;
    return true;
  }
  if (yields_since_ == 0) {
    yields_since_ = now;
    ++yields_;
  }
  if (now - yields_since_ < kLongestYield) return false;
  yields_since_ = 0;  // A machine that is always busy must not keep tiles large for ever.
  return true;
}

Result<std::int64_t> CompressProcess::work(std::int64_t now) {
  if (waiting_.empty()) {
    for (auto& message : in_->consumer().take()) waiting_.push_back(std::move(message));
  }
  std::int64_t next = INT64_MAX;
  if (may_work(now)) {
    compress_one();
    if (!waiting_.empty()) next = now;
  } else if (yields_since_ != 0) {
    next = yields_since_ + kLongestYield;
  }
  for (auto& link : stores_) {
    if (auto pumped = link->pump(now); !pumped) return pass_on(pumped);
    next = std::min(next, link->producer().next_poll(now));
  }
  const auto committed = [this](std::size_t shard) {
    return stores_[shard]->producer().committed_messages();
  };
  for (const auto& done : open_.take_done(committed)) {
    in_->consumer().commit(done.session, done.number);
  }
  if (auto pumped = in_->pump(now); !pumped) return pass_on(pumped);
  if (auto sent = status_->pump(now, [this] { return counters(); }); !sent) return pass_on(sent);
  return std::min({next, in_->consumer().next_poll(now), status_->next_pump()});
}

void CompressProcess::compress_one() {
  const StreamMessage message = std::move(waiting_.front());
  waiting_.pop_front();
  const OpenTiles::Raw from{message.session, message.number};
  const auto drop = [&](const std::string& why) {
    log_warning("dropped: {}", why);
    open_.dropped(from);
  };
  if (message.kind != MessageKind::kTileRaw) {
    return drop(
        fmt::format("message of kind {} instead of a tile", static_cast<int>(message.kind)));
  }
  const auto raw = decode_message<tile_raw_t>(message.payload);
  if (!raw) return drop(raw.error().message);
  if (raw->shard < 0 || raw->shard >= options_.stores) {
    return drop(fmt::format("tile of shard {}, there are {}", raw->shard, options_.stores));
  }
  const auto shard = static_cast<std::size_t>(raw->shard);
  const auto number = stores_[shard]->producer().offer(MessageKind::kTileEncoded,
                                                       encode_message(service_.compress(*raw)));
  open_.answered(from, {shard, number});
}

StatusCounters CompressProcess::counters() const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  const auto& done = service_.counters();
  StatusCounters all{{"tiles", number(done.tiles)},
                     {"tiles_refused", number(done.refused)},
                     {"bytes_in", number(done.bytes_in)},
                     {"bytes_out", number(done.bytes_out)},
                     {"ratio", done.ratio()},
                     {"busy_ms", number(done.busy_us) / 1000},
                     {"queue", number(waiting_.size())},
                     {"results_open", number(open_.size())},
                     {"load", last_load_},
                     {"yields", number(yields_)}};
  std::vector<StreamProducer*> producers;
  for (const auto& link : stores_) producers.push_back(&link->producer());
  add_incoming(in_->consumer(), all);
  add_outgoing(producers, all);
  return all;
}

}  // namespace

Status serve_compress(const CompressOptions& options) {
  CompressProcess process(options);
  if (auto started = process.start(); !started) return started;
  return process.run();
}

}  // namespace voxatlas
