#include "compress/compress_process.hpp"

#include <fmt/format.h>
#include <unistd.h>

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

namespace voxatlas {

namespace {

class CompressProcess {
 public:
  explicit CompressProcess(const CompressOptions& options)
      : options_(options), service_(options.codec) {}

  Status start();
  Status run();

 private:
  Result<std::int64_t> work(std::int64_t now);
  void compress_one();
  std::vector<std::pair<std::string, double>> counters() const;

  CompressOptions options_;
  CompressService service_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<InLink> in_;
  std::vector<std::unique_ptr<OutLink>> stores_;
  std::unique_ptr<StatusPublisher> status_;
  std::deque<StreamMessage> waiting_;
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

Result<std::int64_t> CompressProcess::work(std::int64_t now) {
  if (waiting_.empty()) {
    for (auto& message : in_->consumer().take()) waiting_.push_back(std::move(message));
  }
  const bool room =
      std::ranges::all_of(stores_, [](const auto& link) { return link->producer().has_room(); });
  if (!waiting_.empty() && room) compress_one();
  std::int64_t next = waiting_.empty() || !room ? in_->consumer().next_poll(now) : now;
  for (auto& link : stores_) {
    if (auto pumped = link->pump(now); !pumped) return pass_on(pumped);
    next = std::min(next, link->producer().next_poll(now));
  }
  if (auto pumped = in_->pump(now); !pumped) return pass_on(pumped);
  if (auto sent = status_->pump(now, [this] { return counters(); }); !sent) return pass_on(sent);
  return next;
}

void CompressProcess::compress_one() {
  const StreamMessage message = std::move(waiting_.front());
  waiting_.pop_front();
  // Done with, whatever becomes of it: the store hands a tile out again that does not come back.
  in_->consumer().commit(message.session, message.number);
  const auto raw = message.kind == MessageKind::kTileRaw
                       ? decode_message<tile_raw_t>(message.payload)
                       : Result<tile_raw_t>(fail(ErrorCode::kCorrupt,
                                                 fmt::format("message of kind {} instead of a tile",
                                                             static_cast<int>(message.kind))));
  if (!raw) return log_warning("dropped: {}", raw.error().message);
  if (raw->shard < 0 || raw->shard >= options_.stores) {
    return log_warning("dropped: tile of shard {}, there are {}", raw->shard, options_.stores);
  }
  const auto encoded = service_.compress(*raw);
  if (!encoded) return log_warning("dropped: {}", encoded.error().message);
  stores_[static_cast<std::size_t>(raw->shard)]->producer().offer(MessageKind::kTileEncoded,
                                                                  encode_message(*encoded));
}

std::vector<std::pair<std::string, double>> CompressProcess::counters() const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  const auto& done = service_.counters();
  return {{"tiles", number(done.tiles)},
          {"tiles_refused", number(done.refused)},
          {"bytes_in", number(done.bytes_in)},
          {"bytes_out", number(done.bytes_out)},
          {"busy_ms", number(done.busy_us) / 1000},
          {"queue", number(waiting_.size())}};
}

}  // namespace

Status serve_compress(const CompressOptions& options) {
  constexpr int kPoliteness = 10;  // Import and pictures come first.
  if (nice(kPoliteness) == -1) log_warning("could not lower the own priority");
  CompressProcess process(options);
  if (auto started = process.start(); !started) return started;
  return process.run();
}

}  // namespace voxatlas
