// RenderService's second half: what is in view, what of it is missing, and what is done next.
#include <fmt/format.h>

#include <algorithm>

#include "grid/region_key.hpp"
#include "render/camera_message.hpp"
#include "render/render_service.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kSurveyGap = 3'000;       // So old may be what a picture shows.
constexpr std::int64_t kSurveyAnyway = 250'000;  // Listings grow old though nothing comes in.
constexpr std::int64_t kTick = 50'000;
/// What a stream shows of a tile gets normals across borders once nothing around has changed for so
/// long: while scans come in they would be made for one picture, and each costs others their turn.
constexpr std::int64_t kCalm = 200'000;

std::uint64_t mix(std::uint64_t stamp, std::uint64_t value) { return splitmix64(stamp ^ value); }

/// Until when all is shown that was told of a tile that is not as new as it could be, utime.
std::int64_t shown_until(const TreeCache::Standing& tile, Moment now) {
  std::int64_t first = tile.stale.told;
  if (first == 0 && tile.fine && tile.behind_since > 0) {  // Told of by a listing, so long ago.
    first = now.utime - (now.steady - tile.behind_since);
  }
  return std::max<std::int64_t>(0, first - 1);
}

}  // namespace

bool RenderService::needs_survey(const Client& client, Moment now) const {
  if (!client.view || client.view->over()) return false;
  const std::int64_t age = now.steady - client.surveyed_at;
  if (client.surveyed_place != client.view->place()) return true;
  return (client.surveyed != generation_ && age >= kSurveyGap) || age >= kSurveyAnyway;
}

void RenderService::survey(Client& client, Moment now) {
  auto seen = directory_.look(client.view->camera(), now.steady);
  client.surveyed = generation_;
  client.surveyed_at = now.steady;
  client.surveyed_place = client.view->place();
  if (!seen) {
    render_request_t request{};
    request.client = client.view->question().client;
    request.id = client.view->question().id;
    request.camera = client.asked_camera;
    request.reply_port = client.view->question().reply_port;
    ++counts_.failed;
    drop(client);
    return refuse(request, seen.error().message);
  }
  if (seen->to_list) asker_.list(*seen->to_list, now.steady);
  survey_tiles(client, *seen, now);
}

void RenderService::survey_tiles(Client& client, const TileDirectory::View& seen, Moment now) {
  const View& view = *client.view;
  const bool moving = view.question().stream && !view.question().path;
  // A picture shows what was durable when it was asked for; a stream what is so now.
  const std::int64_t asked = moving ? now.utime : now.utime - (now.steady - view.since());
  const int free_depth = view.question().free_depth;
  std::vector<std::pair<std::int64_t, TileKey>> stale;
  Sight sight;
  sight.trees = std::make_shared<PictureTrees>();
  sight.listed = seen.listed_at > 0;
  sight.complete = sight.listed && seen.listed_at + TileDirectory::kFresh >= view.since();
  sight.shown_until = sight.listed ? now.utime : 0;
  sight.progress_at = client.sight.progress_at;
  client.asks.clear();
  client.coarse.clear();
  client.fine.clear();
  client.rough.clear();
  for (const TileKey key : seen.tiles) {
    const auto tile = cache_.look(key, directory_.version(key), now.steady, free_depth);
    if (tile.free) {
      sight.trees->free.push_back({key, tile.free.get()});
      sight.trees->held_free.push_back(tile.free);
    }
    if (tile.tree) {
      sight.trees->placed.push_back({key, tile.tree.get()});
      sight.trees->held.push_back(tile.tree);
      sight.newest_version = std::max(sight.newest_version, tile.tree->version());
      sight.stamp = mix(sight.stamp, mix(key.morton(), tile.serial));
    }
    if (tile.complete) {
      if (tile.tree && !tile.smooth) {
        if (!moving || now.steady - tile.rough_at >= kCalm) client.rough.push_back(key);
        sight.complete = false;
      }
      continue;
    }
    sight.shown_until = std::min(sight.shown_until, shown_until(tile, now));
    const bool no_room = tile.must_ask && !tile.tree && cache_.full();
    if (tile.must_ask && !no_room) client.asks.push_back(key);
    if (tile.must_build && !tile.tree) client.coarse.push_back(key);
    if (tile.must_build && tile.tree) stale.emplace_back(tile.stale.told, key);
    if (tile.fine && tile.stale.durable >= asked) continue;  // It changed after that.
    ++sight.missing;
    sight.bare = sight.bare || !(tile.tree || no_room);
    sight.complete = sight.complete && no_room;
  }
  // Those stale for longest first: near ones that change with every scan would have all the turns.
  std::stable_sort(stale.begin(), stale.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [since, key] : stale) client.fine.push_back(key);
  const bool progress = client.sight.listed ? sight.missing < client.sight.missing : sight.listed;
  if (progress) sight.progress_at = now.steady;
  const bool lacks = !sight.complete;
  if (lacks && client.lacking_since == 0) client.lacking_since = now.steady;
  client.sight = std::move(sight);
}

/// The first of everybody, then the second of everybody, and so on.
template <class Lists>
static std::vector<TileKey> round_robin(const Lists& lists) {
  std::vector<TileKey> keys;
  std::size_t longest = 0;
  for (const auto* list : lists) longest = std::max(longest, list->size());
  for (std::size_t rank = 0; rank < longest; ++rank) {
    for (const auto* list : lists) {
      if (rank < list->size()) keys.push_back((*list)[rank]);
    }
  }
  return keys;
}

/// Not the whole lists: what is wanted most may be another tile a moment later.
void RenderService::ask_for_tiles(Moment now) {
  constexpr std::size_t kAhead = 128;
  std::vector<const std::vector<TileKey>*> lists;
  for (const auto& [id, client] : clients_) {
    if (client.view) lists.push_back(&client.asks);
  }
  std::vector<WantedTile> wanted;
  for (const TileKey key : round_robin(lists)) {
    if (wanted.size() >= kAhead) break;
    if (asker_.asking_for(key)) continue;
    const auto tile = cache_.look(key, directory_.version(key), now.steady);
    if (tile.must_ask) wanted.push_back({key, tile.ask_depth});
  }
  asker_.want(std::move(wanted));
}

void RenderService::give_builds(Output& out) {
  for (auto list : {&Client::coarse, &Client::fine, &Client::rough}) {
    if (building_ >= config_.builds) return;
    std::vector<const std::vector<TileKey>*> lists;
    for (const auto& [id, client] : clients_) {
      if (client.view) lists.push_back(&(client.*list));
    }
    for (const TileKey key : round_robin(lists)) {
      if (building_ >= config_.builds) return;
      auto job = cache_.job(key, list == &Client::rough);  // A list may be older than a tree.
      if (!job) continue;
      out.builds.push_back(std::move(*job));
      ++building_;
    }
  }
}

/// The client who has waited longest, of those for whom there is something to paint.
void RenderService::give_paint(Output& out, Moment now) {
  if (painting_) return;
  std::vector<Clients::iterator> order;
  for (auto it = clients_.begin(); it != clients_.end(); ++it) {
    if (it->second.view) order.push_back(it);
  }
  std::sort(order.begin(), order.end(),
            [](auto a, auto b) { return a->second.served < b->second.served; });
  for (const auto client : order) {
    if (paint_of(client, out, now)) return;
  }
}

bool RenderService::paint_of(Clients::iterator at, Output& out, Moment now) {
  Client& client = at->second;
  const std::int32_t port = client.view->question().reply_port;
  if (port != 0 && !config_.has_room(port, at->first)) return false;
  auto shot = client.view->next(client.sight, now.steady);
  if (!shot) return false;
  out.paint = std::move(shot->job);
  shot->job.ticket = out.paint->ticket;
  painting_.emplace(Painting{at->first, nullptr, std::move(*shot), now.steady, 0, false});
  painting_->shot.job.camera = out.paint->camera;
  if (client.lacking_since > 0) {
    painting_->fetch_ms = static_cast<double>(now.steady - client.lacking_since) / 1000;
    client.lacking_since = 0;
  }
  client.served = ++turn_;
  if (client.sight.listed) return true;
  PaintedPicture none;
  none.ticket = out.paint->ticket;
  none.sound =
      fail(ErrorCode::kUnavailable, "the tile stores have not said in time which tiles there are");
  out.paint.reset();
  on_painted(std::move(none), now);
  return false;
}

void RenderService::give_refusals(Output& out, Moment now) {
  if (refusals_.empty() || now.steady - refused_at_ < kErrorGap) return;
  refused_at_ = now.steady;
  auto refusal = refusals_.extract(refusals_.begin());
  refusal.mapped().frame.utime = now.utime;
  out.frames.push_back(std::move(refusal.mapped()));
}

RenderService::Output RenderService::advance(Moment now) {
  Output out;
  take_arrivals(now);
  for (auto& [id, client] : clients_) {
    if (!client.view) continue;
    const std::int64_t deadline = client.view->question().deadline;
    if (deadline > 0 && deadline < now.utime) {
      counts_.expired += !client.view->question().stream;
      drop(client);
      discard_painting(id);
    } else if (needs_survey(client, now)) {
      survey(client, now);
    }
  }
  cache_.trim(now.steady);
  give_paint(out, now);
  ask_for_tiles(now);
  give_builds(out);
  out.questions = asker_.poll(now.steady);
  give_refusals(out, now);
  for (OutgoingFrame& frame : ready_) out.frames.push_back(std::move(frame));
  ready_.clear();
  return out;
}

std::int64_t RenderService::next_time(std::int64_t now) const {
  std::int64_t next = asker_.next_poll();
  if (!refusals_.empty()) next = std::min(next, refused_at_ + kErrorGap);
  for (const auto& [id, client] : clients_) {
    if (!client.view) continue;
    next = std::min({next, now + kTick, client.view->next_time(now)});
    if (client.surveyed != generation_) next = std::min(next, client.surveyed_at + kSurveyGap);
  }
  return next;
}

}  // namespace voxatlas
