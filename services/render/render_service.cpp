#include "render/render_service.hpp"

#include <algorithm>

#include "base/log.hpp"
#include "render/camera_message.hpp"

namespace voxatlas {
namespace {

constexpr std::int8_t kCancel = 2;
constexpr std::size_t kRemembered = 256;  // Clients whose pacers are kept.

std::size_t active(const auto& clients) {
  return static_cast<std::size_t>(std::count_if(
      clients.begin(), clients.end(), [](const auto& c) { return c.second.view != nullptr; }));
}

}  // namespace

RenderService::RenderService(const Grid& grid, const AskerConfig& asker, RenderConfig config)
    : grid_(grid),
      config_(std::move(config)),
      roll_(config_.instance),
      directory_(grid),
      asker_(grid, asker),
      cache_(config_.cache_bytes) {}

void RenderService::on_request(const render_request_t& request, Moment now) {
  ++counts_.requests;
  const auto known = clients_.find(request.client);
  if (known != clients_.end() && known->second.view && request.kind != kCancel) {
    if (known->second.view->question().id == request.id) return;  // It is being answered.
    ++counts_.replaced;
  }
  if (known != clients_.end()) drop(known->second);
  if (request.kind == kCancel) {
    discard_painting(request.client);
    refusals_.erase(request.client);
    return;
  }
  if (!roll_.answers(request.client, now.steady)) {
    ++counts_.elsewhere;
    return;
  }
  if (request.deadline > 0 && request.deadline < now.utime) {
    ++counts_.expired;
    return;
  }
  if (active(clients_) >= kMaxClients) {
    ++counts_.refused;
    return refuse(request, fmt::format("{} clients are served already", kMaxClients));
  }
  begin(clients_[request.client], request, now);
  forget_clients();
}

void RenderService::begin(Client& client, const render_request_t& request, Moment now) {
  auto question = Question::create(request, config_.limits, now.utime);
  if (!question) {
    ++counts_.failed;
    return refuse(request, question.error().message);
  }
  client.view = std::make_unique<View>(std::move(*question), ++tickets_, client.pacer, now.steady);
  client.asked_camera = request.camera;
  client.sight = Sight();
  client.surveyed = 0;
  client.surveyed_place = -1;
  client.lacking_since = 0;
  refusals_.erase(request.client);
}

/// Ends what is done for a client; what is being painted still goes out.
void RenderService::drop(Client& client) {
  if (!client.view) return;
  if (painting_ && painting_->shot.job.ticket == client.view->ticket()) {
    painting_->orphan = std::move(client.view);
  }
  client.view.reset();
  client.sight = Sight();
  client.asks.clear();
  client.coarse.clear();
  client.fine.clear();
  client.rough.clear();
}

void RenderService::discard_painting(std::int64_t client) {
  if (painting_ && painting_->client == client) painting_->unwanted = true;
}

/// A frame that says why there is no picture; a client's latest only, and not too many a second.
void RenderService::refuse(const render_request_t& request, std::string why) {
  if (refusals_.size() >= kMaxClients && !refusals_.contains(request.client)) return;
  OutgoingFrame out;
  frame_t& frame = out.frame;
  frame.client = request.client;
  frame.id = request.id;
  frame.renderer = config_.index;
  frame.final = 1;
  frame.last = 1;
  frame.camera = request.camera;
  frame.error = std::move(why);
  out.reply_port = way_back(request);
  log_warning("request {} of client {}: {}", frame.id, frame.client, frame.error);
  refusals_.insert_or_assign(request.client, std::move(out));
}

void RenderService::forget_clients() {
  while (clients_.size() > kRemembered) {
    auto oldest = clients_.end();
    for (auto it = clients_.begin(); it != clients_.end(); ++it) {
      const bool painted = painting_ && painting_->client == it->first;
      if (it->second.view || painted) continue;
      if (oldest == clients_.end() || it->second.served < oldest->second.served) oldest = it;
    }
    if (oldest == clients_.end()) return;
    clients_.erase(oldest);
  }
}

void RenderService::on_gone(std::int64_t client) {
  refusals_.erase(client);
  if (const auto known = clients_.find(client); known != clients_.end()) {
    drop(known->second);
  }
  discard_painting(client);
}

void RenderService::on_tile_update(const tile_update_t& update, Moment now) {
  const auto key = grid_.tile_from_morton(static_cast<std::uint64_t>(update.tile));
  if (!key || update.version <= 0) return;
  const auto version = static_cast<std::uint64_t>(update.version);
  const bool watched = directory_.update(*key, version, now.steady);
  cache_.update({*key, version, update.content, update.payload, {update.utime, now.utime}}, watched,
                now.steady);
  ++generation_;
}

void RenderService::on_tiles_reply(const tiles_reply_t& reply, Moment now) {
  asker_.on_tiles_reply(reply, now.steady);
}

void RenderService::on_tile_reply(const tile_reply_t& reply, Moment now) {
  asker_.on_tile_reply(reply, now.steady);
}

void RenderService::take_arrivals(Moment now) {
  for (const Listing& listing : asker_.take_listings()) {
    directory_.take(listing.range, listing.tiles, listing.asked);
    for (const auto& [key, version] : listing.tiles) cache_.hear(key, version, now.steady);
    ++generation_;
  }
  for (ArrivedTile& tile : asker_.take_tiles()) {
    cache_.take(std::move(tile), now.steady);
    ++counts_.fetched;
    ++generation_;
  }
}

void RenderService::on_built(BuiltTile built, Moment now) {
  --building_;
  ++counts_.built;
  ++generation_;
  cache_.take(std::move(built), now.steady);
}

void RenderService::on_painted(PaintedPicture picture, Moment now) {
  if (!painting_ || picture.ticket != painting_->shot.job.ticket) return;  // Never.
  const auto client = clients_.find(painting_->client);
  View* view = painting_->orphan ? painting_->orphan.get() : client->second.view.get();
  const View::Mark mark = view->painted(picture, now.steady);
  counts_.last_frame_ms = picture.all_ms;
  counts_.over_budget += mark.late;
  if (mark.frame && !painting_->unwanted) {
    ready_.push_back(frame_of(*view, mark, picture, now));
    ++counts_.frames;
    counts_.missing += static_cast<std::uint64_t>(painting_->shot.sight.missing);
    counts_.failed += !picture.sound;
  }
  if (!painting_->orphan && view->over()) client->second.view.reset();
  painting_.reset();
}

OutgoingFrame RenderService::frame_of(const View& view, const View::Mark& mark,
                                      PaintedPicture& picture, Moment now) const {
  const Shot& shot = painting_->shot;
  OutgoingFrame out;
  out.reply_port = view.question().reply_port;
  frame_t& frame = out.frame;
  frame.utime = now.utime;
  frame.client = view.question().client;
  frame.id = view.question().id;
  frame.renderer = config_.index;
  frame.sequence = mark.sequence;
  frame.place = shot.place;
  frame.final = mark.final;
  frame.last = mark.last;
  frame.camera = to_message(shot.job.camera);
  frame.depth = static_cast<std::int8_t>(picture.depth);
  frame.threshold = shot.threshold;
  frame.samples = static_cast<std::int8_t>(shot.samples);
  frame.tiles = static_cast<std::int32_t>(picture.tiles);
  frame.tiles_missing = shot.sight.missing;
  frame.newest_version = static_cast<std::int64_t>(shot.sight.newest_version);
  frame.shown_until = shot.sight.shown_until;
  frame.cells = static_cast<std::int64_t>(picture.cells);
  frame.over_budget = mark.over_budget;
  frame.wait_ms = static_cast<double>(painting_->begun - shot.due) / 1000;
  frame.fetch_ms = painting_->fetch_ms;
  frame.draw_ms = picture.draw_ms;
  frame.shade_ms = picture.shade_ms;
  frame.overlay_ms = picture.overlay_ms;
  frame.encode_ms = picture.encode_ms;
  frame.format = static_cast<std::int8_t>(view.question().encode.format);
  if (!picture.sound) {
    frame.error = picture.sound.error().message;
    return out;
  }
  frame.quality = static_cast<std::int8_t>(picture.quality);
  frame.data = std::move(picture.data);
  frame.size = static_cast<std::int32_t>(frame.data.size());
  frame.depth_format = static_cast<std::int8_t>(view.question().encode.depth);
  frame.depth_scale = picture.depth_scale;
  frame.depth_data = std::move(picture.depth_data);
  frame.depth_size = static_cast<std::int32_t>(frame.depth_data.size());
  return out;
}

std::vector<std::pair<std::string, double>> RenderService::counters(std::int64_t now) const {
  const auto number = [](auto value) { return static_cast<double>(value); };
  return {{"requests", number(counts_.requests)},
          {"requests_waiting", number(active(clients_))},
          {"requests_replaced", number(counts_.replaced)},
          {"requests_refused", number(counts_.refused)},
          {"requests_expired", number(counts_.expired)},
          {"requests_failed", number(counts_.failed)},
          {"requests_elsewhere", number(counts_.elsewhere)},
          {"renderers", number(roll_.alive(now))},
          {"frames", number(counts_.frames)},
          {"frames_over_budget", number(counts_.over_budget)},
          {"last_frame_ms", counts_.last_frame_ms},
          {"tiles_fetched", number(counts_.fetched)},
          {"tiles_built", number(counts_.built)},
          {"tiles_missing", number(counts_.missing)},
          {"tiles_broken", number(cache_.broken())},
          {"answers_refused", number(asker_.refused())},
          {"cache_tiles", number(cache_.tiles())},
          {"cache_bytes", number(cache_.bytes())}};
}

}  // namespace voxatlas
