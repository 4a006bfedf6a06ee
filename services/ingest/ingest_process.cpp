#include "ingest/ingest_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>

#include "atlas/model_parameters.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"
#include "bus/stream_link.hpp"
#include "ingest/delta_links.hpp"
#include "ingest/ingest_service.hpp"
#include "ingest/plain_scans.hpp"

namespace voxatlas {

namespace {

class IngestProcess {
 public:
  explicit IngestProcess(const IngestOptions& options) : options_(options) {}

  Status start();
  Status run();

 private:
  Result<ModelParameters> ask_for_parameters();
  Result<std::int64_t> work(std::int64_t now);
  void take_scans();
  StatusCounters counters() const;

  IngestOptions options_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<InLink> scans_in_;
  std::unique_ptr<DeltaLinks> deltas_out_;
  std::unique_ptr<IngestService> service_;
  std::unique_ptr<PlainScans> plain_;
  std::unique_ptr<StatusPublisher> status_;
  std::deque<StreamMessage> reliable_waiting_;
  std::deque<scan_t> plain_waiting_;
  std::uint64_t plain_dropped_ = 0;
};

Status IngestProcess::start() {
  auto bus = Bus::create(options_.url);
  if (!bus) return pass_on(bus);
  bus_ = std::move(*bus);
  status_ = std::make_unique<StatusPublisher>(*bus_, "ingest", options_.index);
  auto endpoint = Endpoint::create(EndpointClass::kIngest, options_.index);
  if (!endpoint) return pass_on(endpoint);
  auto parameters = ask_for_parameters();
  if (!parameters) return pass_on(parameters);
  service_ = std::make_unique<IngestService>(*parameters, options_.workers);
  plain_ = std::make_unique<PlainScans>(options_.index, options_.ingests, random_id());
  auto links = DeltaLinks::create(*bus_, options_.stores);
  if (!links) return pass_on(links);
  deltas_out_ = std::move(*links);
  auto scans_in = InLink::create(*bus_, *endpoint, ConsumerConfig{});
  if (!scans_in) return pass_on(scans_in);
  scans_in_ = std::move(*scans_in);
  bus_->subscribe<scan_t>(kScanChannel, [this](const scan_t& part) {
    if (!plain_->is_ours(part.source)) return;
    auto whole = plain_->offer(part, steady_utime());
    if (!whole) return log_warning("plain scan dropped: {}", whole.error().message);
    if (*whole) plain_waiting_.push_back(std::move(**whole));
  });
  return {};
}

Result<ModelParameters> IngestProcess::ask_for_parameters() {
  const Endpoint self = Endpoint::for_this_client();
  auto url = url_at_port(options_.url, self.port_offset());
  if (!url) return pass_on(url);
  auto port = Bus::create(*url);
  if (!port) return pass_on(port);
  StoreClient client(*bus_, **port, self);
  std::optional<ModelParameters> common;
  for (std::int32_t shard = 0; shard < options_.stores; ++shard) {
    status_->set_state(false, fmt::format("waiting for tilestore {}", shard));
    Result<model_reply_t> reply = fail(ErrorCode::kUnavailable, "");
    while (!reply) {
      if (stop_requested()) return fail(ErrorCode::kUnavailable, "stopped before it was ready");
      if (auto sent = status_->pump(steady_utime(), [] { return StatusCounters{}; }); !sent)
        return pass_on(sent);
      reply = client.model(shard, "", 0, 400'000);
      if (!reply && reply.error().code != ErrorCode::kUnavailable) return pass_on(reply);
    }
    auto parameters = decode_parameters(reply->parameters);
    if (!parameters) return pass_on(parameters, fmt::format("tilestore {}", shard));
    if (static_cast<std::int32_t>(parameters->shards) != options_.stores) {
      return fail(ErrorCode::kInvalid, fmt::format("started with --stores {}, but the model has {}",
                                                   options_.stores, parameters->shards));
    }
    if (common && *common != *parameters) {
      return fail(ErrorCode::kInvalid, fmt::format("tilestore {} has another model: {}", shard,
                                                   describe_difference(*parameters, *common)));
    }
    common = *parameters;
  }
  return *common;
}

Status IngestProcess::run() {
  status_->set_state(true, "ready");
  log_info("ready: {} workers, {} tilestores", options_.workers, options_.stores);
  ServiceLoop loop;
  loop.buses = {bus_.get(), &scans_in_->port()};
  loop.wake_fds = {service_->fd()};
  loop.work = [this](std::int64_t now) { return work(now); };
  return loop.run();
}

Result<std::int64_t> IngestProcess::work(std::int64_t now) {
  plain_->expire(now);
  take_scans();
  for (const auto& outgoing : service_->finished()) deltas_out_->send(outgoing);
  if (auto pumped = deltas_out_->pump(*service_, now); !pumped) return pass_on(pumped);
  for (const auto& done : service_->acknowledged()) {
    scans_in_->consumer().commit(done.session, done.number);
  }
  if (auto pumped = scans_in_->pump(now); !pumped) return pass_on(pumped);
  if (auto sent = status_->pump(now, [this] { return counters(); }); !sent) return pass_on(sent);
  return std::min(
      {deltas_out_->next_poll(now), scans_in_->consumer().next_poll(now), status_->next_pump()});
}

void IngestProcess::take_scans() {
  const auto has_room = [this] { return service_->has_room() && deltas_out_->has_room(); };
  if (reliable_waiting_.empty() && has_room()) {
    for (auto& message : scans_in_->consumer().take()) {
      reliable_waiting_.push_back(std::move(message));
    }
  }
  while (!reliable_waiting_.empty() && has_room()) {
    const StreamMessage message = std::move(reliable_waiting_.front());
    reliable_waiting_.pop_front();
    service_->take_message(message.kind, message.payload, {message.session, message.number});
  }
  while (!plain_waiting_.empty() && has_room() && service_->has_room_for_plain()) {
    plain_->adopt(plain_waiting_.front());
    service_->take(plain_waiting_.front(), {});
    plain_waiting_.pop_front();
  }
  while (plain_waiting_.size() > IngestService::kMaxInFlight) {
    plain_waiting_
        .pop_front();  // Best effort: a logger cannot be slowed. The newest is worth most.
    ++plain_dropped_;
  }
}

StatusCounters IngestProcess::counters() const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  const auto& scans = service_->counters();
  const auto& plain = plain_->counters();
  StatusCounters all{{"queue", number(reliable_waiting_.size() + plain_waiting_.size())},
                     {"scans", number(scans.scans)},
                     {"scans_refused", number(scans.refused)},
                     {"scans_unidentified", number(scans.unidentified)},
                     {"scans_acknowledged", number(scans.acknowledged)},
                     {"scans_in_flight", number(service_->in_flight())},
                     {"rays", number(scans.rays.rays)},
                     {"rays_beyond_max", number(scans.rays.beyond_max)},
                     {"rays_below_min", number(scans.rays.below_min)},
                     {"rays_not_finite", number(scans.rays.not_finite)},
                     {"rays_off_cube", number(scans.rays.off_cube)},
                     {"plain_scans", number(plain.whole)},
                     {"plain_incomplete", number(plain.incomplete)},
                     {"plain_gaps", number(plain.gaps)},
                     {"plain_dropped", number(plain_dropped_)}};
  add_incoming(scans_in_->consumer(), all);
  add_outgoing(deltas_out_->producers(), all);
  service_->marks().add_to(all);
  return all;
}

}  // namespace

Status serve_ingest(const IngestOptions& options) {
  IngestProcess process(options);
  if (auto started = process.start(); !started) return stop_requested() ? Status{} : started;
  return process.run();
}

}  // namespace voxatlas
