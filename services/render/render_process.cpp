#include "render/render_process.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"
#include "render/frame_sender.hpp"
#include "render/render_service.hpp"
#include "render/store_tiles.hpp"

namespace voxatlas {
namespace {

class RenderProcess {
 public:
  explicit RenderProcess(const RenderProcessOptions& options) : options_(options) {}

  Status start();
  Status run();

 private:
  Result<ModelParameters> parameters_of(std::int32_t shard);
  Result<ModelParameters> common_parameters();
  Result<std::int64_t> work(std::int64_t now);

  RenderProcessOptions options_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Bus> port_;  // Our own: the stores' answers come here.
  std::unique_ptr<StoreClient> stores_;
  std::unique_ptr<RenderService> service_;
  std::unique_ptr<FrameSender> frames_;
  std::unique_ptr<StatusPublisher> status_;
};

Status RenderProcess::start() {
  auto bus = Bus::create(options_.url);
  if (!bus) return pass_on(bus);
  bus_ = std::move(*bus);
  status_ = std::make_unique<StatusPublisher>(*bus_, "render", options_.index);
  const Endpoint self = Endpoint::for_this_client();
  auto url = url_at_port(options_.url, self.port_offset());
  if (!url) return pass_on(url);
  auto port = Bus::create(*url);
  if (!port) return pass_on(port);
  port_ = std::move(*port);
  stores_ = std::make_unique<StoreClient>(*bus_, *port_, self);
  auto parameters = common_parameters();
  if (!parameters) return pass_on(parameters);
  const Grid grid = parameters->grid();
  RenderConfig config;
  config.cache_bytes = options_.cache_mb << 20;
  service_ =
      std::make_unique<RenderService>(grid, store_tiles(*stores_, grid, options_.stores), config);
  frames_ = std::make_unique<FrameSender>(*bus_);
  bus_->subscribe<render_request_t>(kRenderRequestChannel, [this](const render_request_t& request) {
    service_->on_request(request);
  });
  bus_->subscribe<tile_update_t>(kTileUpdateChannel, [this](const tile_update_t& update) {
    service_->on_tile_update(update);
  });
  return {};
}

/// Asks until the shard answers, telling everyone whom we wait for.
Result<ModelParameters> RenderProcess::parameters_of(std::int32_t shard) {
  constexpr std::int64_t kOneTry = 400'000;
  status_->set_state(false, fmt::format("waiting for tilestore {}", shard));
  while (!stop_requested()) {
    auto sent = status_->pump(steady_utime(), [] { return StatusCounters{}; });
    if (!sent) return pass_on(sent);
    auto reply = stores_->model(shard, "", 0, kOneTry);
    if (reply) return decode_parameters(reply->parameters);
    if (reply.error().code != ErrorCode::kUnavailable) return pass_on(reply);
  }
  return fail(ErrorCode::kUnavailable,
              fmt::format("stopped while waiting for tilestore {}", shard));
}

Result<ModelParameters> RenderProcess::common_parameters() {
  std::optional<ModelParameters> common;
  for (std::int32_t shard = 0; shard < options_.stores; ++shard) {
    auto parameters = parameters_of(shard);
    if (!parameters) return pass_on(parameters, fmt::format("tilestore {}", shard));
    if (parameters->shards != static_cast<std::uint32_t>(options_.stores)) {
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

Status RenderProcess::run() {
  status_->set_state(true, "ready");
  log_info("ready: {} tilestores, cache of {} MB", options_.stores, options_.cache_mb);
  ServiceLoop loop;
  loop.buses = {bus_.get(), port_.get()};
  loop.work = [this](std::int64_t now) { return work(now); };
  return loop.run();
}

Result<std::int64_t> RenderProcess::work(std::int64_t now) {
  if (const auto out = service_->work()) {
    if (!out->frame.error.empty()) {
      log_warning("request {} of client {}: {}", out->frame.id, out->frame.client,
                  out->frame.error);
    }
    if (auto sent = frames_->send(*out, now); !sent) {
      log_warning("frame {} not sent: {}", out->frame.sequence, sent.error().message);
    }
  }
  if (auto pumped = frames_->pump(now); !pumped) return pass_on(pumped);
  const auto counters = [this] {
    StatusCounters all = service_->counters();
    add_outgoing(frames_->producers(), all);
    return all;
  };
  if (auto sent = status_->pump(now, counters); !sent) return pass_on(sent);
  return service_->idle() ? std::min(frames_->next_poll(now), status_->next_pump()) : now;
}

}  // namespace

Status serve_render(const RenderProcessOptions& options) {
  RenderProcess process(options);
  if (auto started = process.start(); !started) return stop_requested() ? Status{} : started;
  return process.run();
}

}  // namespace voxatlas
