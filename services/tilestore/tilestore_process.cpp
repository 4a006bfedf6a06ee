#include "tilestore/tilestore_process.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>

#include "atlas/memory_plan.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/checkpoint_wire.hpp"
#include "bus/requests.hpp"
#include "bus/service_loop.hpp"
#include "bus/stream_link.hpp"
#include "store/store_location.hpp"
#include "tilestore/checkpoints.hpp"
#include "tilestore/question_desk.hpp"
#include "tilestore/raw_tiles.hpp"
#include "tilestore/stall_reporter.hpp"
#include "tilestore/tile_queries.hpp"
#include "tilestore/tilestore_service.hpp"

namespace voxatlas {
namespace {

RocksDbOptions store_options(const MemoryPlan& plan) {
  RocksDbOptions options;
  options.memory_bytes = std::min(options.memory_bytes, plan.store);
  options.write_buffer_bytes = std::min(options.write_buffer_bytes, plan.write_buffers);
  return options;
}

AtlasOptions atlas_options(const MemoryPlan& plan, const TilestoreOptions& from) {
  AtlasOptions options;
  options.cache_bytes = plan.tiles;
  options.journal_max_bytes = from.journal_max_bytes;
  options.rest_seconds = from.rest_seconds;
  options.rest_bytes = from.rest_bytes;
  options.keep_journal = from.keep_journal;
  return options;
}

/// Deltas that have arrived and not been taken wait here; then the ingests' credit runs dry.
ConsumerConfig consumer_config(const MemoryPlan& plan) {
  ConsumerConfig config;
  config.max_held_bytes = std::min(config.max_held_bytes, plan.arriving);
  return config;
}

class TilestoreProcess {
 public:
  TilestoreProcess(const TilestoreOptions& options, const MemoryPlan& plan)
      : options_(options), plan_(plan) {}

  Status start();
  Status run();

 private:
  Status open_model();
  Status join_bus();
  void answer(const checkpoint_request_t& request);
  Result<std::int64_t> work(std::int64_t now);
  Status take_messages();
  Status take_message(const StreamMessage& message);
  Status take_encoded(const StreamMessage& message);
  Status commit(std::int64_t now);
  Status publish(const tile_update_t& update);
  StatusCounters counters() const;

  TilestoreOptions options_;
  MemoryPlan plan_;
  std::unique_ptr<WatchedStore> store_;
  std::unique_ptr<Atlas> atlas_;
  std::unique_ptr<TilestoreService> service_;
  std::unique_ptr<TileQueries> queries_;
  std::unique_ptr<Checkpoints> checkpoints_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<QuestionDesk> questions_;
  std::unique_ptr<ReplyPorts> ports_;  ///< Of those who asked for a checkpoint.
  std::unique_ptr<InLink> in_;
  std::unique_ptr<RawTiles> raw_tiles_;
  std::unique_ptr<StatusPublisher> status_;
  std::deque<StreamMessage> waiting_;
  std::int64_t retry_commit_at_ = 0;
  std::uint64_t updates_published_ = 0;
};

Status TilestoreProcess::start() {
  if (auto opened = open_model(); !opened) return opened;
  return join_bus();
}

Status TilestoreProcess::open_model() {
  const auto began = steady_utime();
  const auto shard = static_cast<ShardId>(options_.shard);
  auto location = StoreLocation::parse(options_.data_dir);
  if (!location) return pass_on(location);
  auto store = open_store(*location, shard, store_options(plan_));
  if (!store) return pass_on(store);
  store_ = std::make_unique<WatchedStore>(std::move(*store));
  auto stored = Atlas::stored_parameters(*store_, shard);
  if (!stored) return pass_on(stored);
  auto parameters =
      apply_options(options_.model, options_.shards, stored->value_or(ModelParameters{}));
  if (!parameters) return pass_on(parameters);
  auto atlas = Atlas::open(*store_, shard, *parameters, atlas_options(plan_, options_));
  if (!atlas) return pass_on(atlas, options_.data_dir);
  atlas_ = std::move(*atlas);
  service_ = std::make_unique<TilestoreService>(*atlas_, plan_.commit);
  queries_ = std::make_unique<TileQueries>(*atlas_, *store_);
  checkpoints_ = std::make_unique<Checkpoints>(*store_, location->folder);
  log_info("shard {} of {} in {}: {} in {} ms", shard, options_.shards, options_.data_dir,
           *stored ? "opened" : "made", (steady_utime() - began) / 1000);
  return {};
}

Status TilestoreProcess::join_bus() {
  auto bus = Bus::create(options_.url);
  if (!bus) return pass_on(bus);
  bus_ = std::move(*bus);
  status_ = std::make_unique<StatusPublisher>(*bus_, "tilestore", options_.shard);
  auto endpoint = Endpoint::create(EndpointClass::kStore, options_.shard);
  if (!endpoint) return pass_on(endpoint);
  auto in = InLink::create(*bus_, *endpoint, consumer_config(plan_));
  if (!in) return pass_on(in);
  in_ = std::move(*in);
  auto raw_tiles = RawTiles::create(*bus_, options_.compressors);
  if (!raw_tiles) return pass_on(raw_tiles);
  raw_tiles_ = std::move(*raw_tiles);
  questions_ = std::make_unique<QuestionDesk>(*bus_, *queries_, options_.shard);
  ports_ = std::make_unique<ReplyPorts>(*bus_);
  bus_->subscribe<checkpoint_request_t>(
      kCheckpointRequestChannel, [this](const checkpoint_request_t& request) { answer(request); });
  return {};
}

void TilestoreProcess::answer(const checkpoint_request_t& request) {
  if (request.shard != options_.shard || request.deadline < utime_now()) return;
  const auto reply = checkpoints_->answer(request);
  if (!reply) return;  // Not made yet: the question comes again.
  auto port = ports_->at(request.reply_port);
  const Status sent =
      port ? (*port)->publish(kCheckpointReplyChannel, *reply) : Status(pass_on(port));
  if (!sent) {
    log_warning("checkpoint_request_t of client {} not answered: {}", request.client,
                sent.error().message);
  }
}

Status TilestoreProcess::run() {
  status_->set_state(true, "ready");
  log_info("ready");
  const StallReporter stalls(*store_, options_.url, options_.shard, status_->instance());
  ServiceLoop loop;
  loop.buses = {bus_.get(), &in_->port()};
  loop.work = [this](std::int64_t now) { return work(now); };
  if (auto ended = loop.run(); !ended) return ended;
  log_info("stopping: writing {} tiles", atlas_->stats().dirty_tiles);
  return atlas_->flush();
}

Result<std::int64_t> TilestoreProcess::work(std::int64_t now) {
  if (auto taken = take_messages(); !taken) return pass_on(taken);
  if (auto committed = commit(now); !committed) return pass_on(committed);
  if (auto pumped = in_->pump(now); !pumped) return pass_on(pumped);
  const bool idle = waiting_.empty() && service_->waiting() == 0;
  if (auto pumped = raw_tiles_->pump(*atlas_, now, idle); !pumped) return pass_on(pumped);
  if (auto sent = status_->pump(now, [this] { return counters(); }); !sent) return pass_on(sent);
  if (idle && atlas_->stats().dirty_tiles > 0) {
    constexpr std::size_t kTilesAtOnce = 16;  // A few milliseconds: new scans must not wait long.
    auto flushed = atlas_->flush_some(kTilesAtOnce);
    if (!flushed && flushed.error().code != ErrorCode::kNoSpace) return pass_on(flushed);
    if (flushed) return now;
    return std::min(in_->consumer().next_poll(now), status_->next_pump());
  }
  return std::min(
      {in_->consumer().next_poll(now), raw_tiles_->next_poll(now), status_->next_pump()});
}

Status TilestoreProcess::take_messages() {
  if (waiting_.empty() && service_->has_room()) {
    for (auto& message : in_->consumer().take()) waiting_.push_back(std::move(message));
  }
  while (!waiting_.empty() && service_->has_room()) {
    const StreamMessage message = std::move(waiting_.front());
    waiting_.pop_front();
    if (auto taken = take_message(message); !taken) return taken;
  }
  // What waits for its turn takes the place of tiles, so that both keep to the budget.
  const auto lent = std::min(service_->waiting_bytes(), plan_.tiles - plan_.tiles / 4);
  atlas_->limit_cache(plan_.tiles - lent);
  return {};
}

Status TilestoreProcess::take_message(const StreamMessage& message) {
  if (message.kind == MessageKind::kTileEncoded) return take_encoded(message);
  if (message.kind == MessageKind::kScanDelta) {
    questions_->delta_came(steady_utime());
    if (auto delta = decode_message<scan_delta_t>(message.payload)) {
      service_->take(*delta, message.session, message.number);
    } else {
      log_error("message {} of stream {} refused: {}", message.number, message.session,
                delta.error().message);
    }
    return {};
  }
  log_error("message {} of stream {} refused: kind {} is not for a tilestore", message.number,
            message.session, static_cast<int>(message.kind));
  return {};
}

Status TilestoreProcess::take_encoded(const StreamMessage& message) {
  std::optional<tile_update_t> update;
  if (auto encoded = decode_message<tile_encoded_t>(message.payload)) {
    update = service_->take(*encoded);
    if (auto key = TileKey::from_morton(static_cast<std::uint64_t>(encoded->tile))) {
      raw_tiles_->answered(*key);
    }
  }
  in_->consumer().commit(message.session, message.number);  // Best effort: it will be made again.
  return update ? publish(*update) : Status{};
}

/// Counted also where a lost hub does not take it: so subscribers see that they missed it.
Status TilestoreProcess::publish(const tile_update_t& update) {
  ++updates_published_;
  auto sent = bus_->publish(kTileUpdateChannel, update);
  if (!sent && sent.error().code == ErrorCode::kUnavailable) return {};
  return sent;
}

Status TilestoreProcess::commit(std::int64_t now) {
  if (now < retry_commit_at_) return {};
  Status published;
  auto done = service_->commit([&](const tile_update_t& update) {
    if (published) published = publish(update);
  });
  if (!done && done.error().code == ErrorCode::kNoSpace) {
    if (retry_commit_at_ == 0) log_error("no room on disk, waiting: {}", done.error().message);
    status_->set_state(false, "no room on disk");
    retry_commit_at_ = now + 1'000'000;
    return {};
  }
  if (!done) return pass_on(done);
  if (retry_commit_at_ != 0) {
    log_info("there is room on disk again");
    status_->set_state(true, "ready");
    retry_commit_at_ = 0;
  }
  for (const auto& stream : *done) in_->consumer().commit(stream.session, stream.number);
  return published;
}

StatusCounters TilestoreProcess::counters() const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  const auto stats = atlas_->stats();
  const auto& deltas = service_->counters();
  StatusCounters all{{"epoch", number(atlas_->epoch())},
                     {"queue", number(waiting_.size())},
                     {"scans_waiting", number(service_->waiting())},
                     {"scans_applied", number(stats.scans_applied)},
                     {"deltas_applied", number(stats.deltas_applied)},
                     {"commits", number(deltas.commits)},
                     {"duplicates", number(deltas.duplicates)},
                     {"refused", number(deltas.refused)},
                     {"cached_tiles", number(stats.cached_tiles)},
                     {"cached_bytes", number(stats.cached_bytes)},
                     {"dirty_tiles", number(stats.dirty_tiles)},
                     {"journal_bytes", number(stats.journal_bytes)},
                     {"tiles_flushed", number(stats.tiles_flushed)},
                     {"cache_misses", number(stats.cache_misses)},
                     {"resting_tiles", number(stats.resting_tiles)},
                     {"encoded_taken", number(deltas.encoded_taken)},
                     {"encoded_lossy", number(deltas.encoded_lossy)},
                     {"encoded_stale", number(deltas.encoded_stale)},
                     {"encoded_wrong", number(deltas.encoded_wrong)},
                     {"marks_regressed", number(queries_->marks_regressed())},
                     {"updates_published", number(updates_published_)}};
  add_incoming(in_->consumer(), all);
  raw_tiles_->add_to(all);
  questions_->add_to(all);
  service_->marks().add_to(all);
  return all;
}

}  // namespace

Status serve_until_fault(const TilestoreOptions& options, bool& was_ready) {
  auto plan = MemoryPlan::of(options.memory_bytes);
  if (!plan) return pass_on(plan);
  TilestoreProcess process(options, *plan);
  if (auto started = process.start(); !started) return started;
  was_ready = true;
  return process.run();
}

}  // namespace voxatlas
