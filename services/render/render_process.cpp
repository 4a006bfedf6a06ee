#include "render/render_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/credit.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"
#include "render/crew.hpp"
#include "render/frame_sender.hpp"
#include "render/render_service.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kReplyBytes = 60'000;

Moment moment() { return {steady_utime(), utime_now()}; }

class RenderProcess {
 public:
  explicit RenderProcess(const RenderProcessOptions& options) : options_(options) {}

  Status start();
  Status run();

 private:
  Result<ModelParameters> parameters_of(std::int32_t shard);
  Result<ModelParameters> common_parameters();
  Result<AskerConfig> asker_config() const;
  void make_crews(const ModelParameters& parameters);
  void subscribe();
  Result<std::int64_t> work(std::int64_t now);
  Status hand_out(RenderService::Output out);
  void send(const OutgoingFrame& out, std::int64_t now);
  Status tell_status(std::int64_t now);

  RenderProcessOptions options_;
  Endpoint self_ = Endpoint::for_this_client();
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Bus> port_;  // Our own: the stores' answers come here.
  std::unique_ptr<StatusPublisher> status_;
  std::int64_t joined_ = 0;
  std::int64_t client_ = random_id();
  std::unique_ptr<FrameSender> frames_;
  std::unique_ptr<RenderService> service_;
  std::unique_ptr<PaintRoom> room_;  // The painter's; the crews below end before it.
  std::unique_ptr<Crew<BuildJob, BuiltTile>> builders_;
  std::unique_ptr<Crew<PaintJob, PaintedPicture>> painter_;
};

Status RenderProcess::start() {
  auto bus = Bus::create(options_.url);
  if (!bus) return pass_on(bus);
  bus_ = std::move(*bus);
  joined_ = steady_utime();
  status_ = std::make_unique<StatusPublisher>(*bus_, "render", options_.index);
  auto url = url_at_port(options_.url, self_.port_offset());
  if (!url) return pass_on(url);
  auto port = Bus::create(*url);
  if (!port) return pass_on(port);
  port_ = std::move(*port);
  auto parameters = common_parameters();
  if (!parameters) return pass_on(parameters);
  auto asker = asker_config();
  if (!asker) return pass_on(asker);
  frames_ = std::make_unique<FrameSender>(*bus_);
  RenderConfig config;
  config.cache_bytes = options_.cache_mb << 20;
  config.index = options_.index;
  config.instance = status_->instance();
  config.builds = 2 * options_.threads;
  config.has_room = [this](std::int32_t reply_port, std::int64_t client) {
    return frames_->has_room(reply_port, client);
  };
  service_ = std::make_unique<RenderService>(parameters->grid(), *asker, std::move(config));
  make_crews(*parameters);
  subscribe();
  return {};
}

Result<AskerConfig> RenderProcess::asker_config() const {
  constexpr std::size_t kMostAtOnce = 64;
  auto buffer = receive_buffer_of(port_->url());
  if (!buffer) return pass_on(buffer);
  AskerConfig config;
  config.shards = static_cast<std::uint32_t>(options_.stores);
  config.client = client_;
  config.reply_port = self_.port_offset();
  config.at_once = std::clamp<std::size_t>(*buffer / buffer_cost(kReplyBytes), 1, kMostAtOnce);
  return config;
}

void RenderProcess::make_crews(const ModelParameters& parameters) {
  room_ = std::make_unique<PaintRoom>(parameters.grid(), options_.threads);
  const SensorModel sensor = parameters.sensor;
  std::vector<std::function<BuiltTile(BuildJob)>> builders(
      options_.threads, [sensor](BuildJob job) { return build(std::move(job), sensor); });
  builders_ = std::make_unique<Crew<BuildJob, BuiltTile>>(std::move(builders));
  painter_ = std::make_unique<Crew<PaintJob, PaintedPicture>>(
      std::vector<std::function<PaintedPicture(PaintJob)>>{
          [this](PaintJob job) { return room_->paint(std::move(job)); }});
}

void RenderProcess::subscribe() {
  bus_->subscribe<render_request_t>(kRenderRequestChannel, [this](const render_request_t& request) {
    service_->on_request(request, moment());
  });
  bus_->subscribe<tile_update_t>(kTileUpdateChannel, [this](const tile_update_t& update) {
    service_->on_tile_update(update, moment());
  });
  bus_->subscribe<status_t>(
      kStatusChannel, [this](const status_t& status) { service_->on_status(status, moment()); });
  port_->subscribe<tiles_reply_t>(kTilesReplyChannel, [this](const tiles_reply_t& reply) {
    service_->on_tiles_reply(reply, moment());
  });
  port_->subscribe<tile_reply_t>(kTileReplyChannel, [this](const tile_reply_t& reply) {
    service_->on_tile_reply(reply, moment());
  });
}

/// Asks until the shard answers, telling everyone whom we wait for.
Result<ModelParameters> RenderProcess::parameters_of(std::int32_t shard) {
  constexpr std::int64_t kOneTry = 400'000;
  StoreClient stores(*bus_, *port_, self_);
  status_->set_state(false, fmt::format("waiting for tilestore {}", shard));
  while (!stop_requested()) {
    auto sent = status_->pump(steady_utime(), [] { return StatusCounters{}; });
    if (!sent) return pass_on(sent);
    auto reply = stores.model(shard, "", 0, kOneTry);
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
  status_->set_state(false, "listening for other renderers");
  log_info("{} tilestores, cache of {} MB, {} threads", options_.stores, options_.cache_mb,
           options_.threads);
  ServiceLoop loop;
  loop.buses = {bus_.get(), port_.get()};
  loop.wake_fds = {builders_->wake_fd(), painter_->wake_fd()};
  loop.work = [this](std::int64_t now) { return work(now); };
  return loop.run();
}

Result<std::int64_t> RenderProcess::work(std::int64_t now) {
  for (BuiltTile& built : builders_->take()) service_->on_built(std::move(built), moment());
  for (PaintedPicture& picture : painter_->take()) {
    service_->on_painted(std::move(picture), moment());
  }
  if (auto handed = hand_out(service_->advance(moment())); !handed) return pass_on(handed);
  if (auto pumped = frames_->pump(now); !pumped) return pass_on(pumped);
  for (const std::int64_t client : frames_->take_gone()) service_->on_gone(client);
  if (auto told = tell_status(now); !told) return pass_on(told);
  return std::min({service_->next_time(now), frames_->next_poll(now), status_->next_pump()});
}

Status RenderProcess::hand_out(RenderService::Output out) {
  const auto ask = [this](const char* channel, const auto& question) {
    auto sent = bus_->publish(channel, question);
    // While the hub is away a question is lost like any other: it is asked again.
    if (!sent && sent.error().code == ErrorCode::kUnavailable) return Status{};
    return sent;
  };
  if (out.paint) painter_->submit(std::move(*out.paint));
  for (const auto& question : out.questions.lists) {
    if (auto asked = ask(kTilesRequestChannel, question); !asked) return asked;
  }
  for (const auto& question : out.questions.tiles) {
    if (auto asked = ask(kTileRequestChannel, question); !asked) return asked;
  }
  for (BuildJob& job : out.builds) builders_->submit(std::move(job));
  for (const OutgoingFrame& frame : out.frames) send(frame, steady_utime());
  return {};
}

void RenderProcess::send(const OutgoingFrame& out, std::int64_t now) {
  if (auto sent = frames_->send(out, now); !sent) {
    log_warning("frame {} of request {} of client {} not sent: {}", out.frame.sequence,
                out.frame.id, out.frame.client, sent.error().message);
  }
}

Status RenderProcess::tell_status(std::int64_t now) {
  if (now - joined_ >= RendererRoll::kListen) status_->set_state(true, "ready");
  return status_->pump(now, [&] {
    StatusCounters all = service_->counters(now);
    add_outgoing(frames_->producers(), all);
    return all;
  });
}

}  // namespace

Status serve_render(const RenderProcessOptions& options) {
  RenderProcess process(options);
  if (auto started = process.start(); !started) return stop_requested() ? Status{} : started;
  return process.run();
}

}  // namespace voxatlas
