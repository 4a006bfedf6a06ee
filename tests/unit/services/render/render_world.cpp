#include "render_world.hpp"

#include <algorithm>

#include "codec/tile_codec.hpp"
#include "support/engine.hpp"

namespace voxatlas::test {
namespace {

constexpr std::int64_t kClient = 4711;  // Of the renderers at the stores.

bool holds(const tiles_request_t& range, const Index3& index) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::int32_t>(index[axis]);
    if (i < range.min_index[axis] || i > range.max_index[axis]) return false;
  }
  return true;
}

}  // namespace

RenderWorld::RenderWorld(const Setting& setting)
    : paint_us(setting.paint_us),
      setting_(setting),
      rng_(engine()),
      room_(scene.grid(), 1),
      list_questions_(setting.faults, rng_),
      tile_questions_(setting.faults, rng_),
      lists_(setting.faults, rng_),
      tiles_(setting.faults, rng_) {
  for (const auto& [key, tree] : scene.tiles()) stored.emplace(key, std::pair(1, tree));
  for (int i = 0; i < setting.renderers; ++i) {
    AskerConfig asker;
    asker.client = kClient;
    RenderConfig config = setting.config;
    config.index = i;
    config.instance = 100 + i;
    renderers_.push_back({std::make_unique<RenderService>(scene.grid(), asker, config), {}, {}});
  }
  tell_statuses();
}

render_request_t RenderWorld::request() const {
  render_request_t request = broadcast();
  request.format = 1;
  request.reply_port = Endpoint::create(EndpointClass::kClient, 3)->port_offset();
  return request;
}

render_request_t RenderWorld::broadcast() const {
  render_request_t request{};
  request.client = 77;
  request.id = 5;
  request.camera = to_message(camera);
  request.depth = 7;
  request.colouring = "rgb";
  return request;
}

void RenderWorld::ask(const render_request_t& request) {
  for (std::size_t i = 0; i < renderers_.size(); ++i) {
    if (!dead.contains(i)) renderers_[i].service->on_request(request, now);
  }
}

void RenderWorld::tell_statuses() {
  told_at_ = now.steady;
  for (std::size_t from = 0; from < renderers_.size(); ++from) {
    status_t status{};
    status.service = "render";
    status.instance = 100 + static_cast<std::int64_t>(from);
    status.ready = 1;
    if (dead.contains(from)) continue;
    for (auto& renderer : renderers_) renderer.service->on_status(status, now);
  }
}

void RenderWorld::answer(const tiles_request_t& question, Renderer& to) {
  ++listed;
  if (!stores_answer) return;
  tiles_reply_t reply{};
  reply.client = question.client;
  reply.id = question.id;
  reply.shard = question.shard;
  reply.next = -1;
  ByteWriter rows(reply.rows);
  constexpr std::int32_t kPage = 3;  // Short pages: there shall be several.
  for (const auto& [key, tile] : stored) {
    if (static_cast<std::int64_t>(key.morton()) < question.from) continue;
    if (!holds(question, key.index())) continue;
    if (reply.tiles == kPage) {
      reply.next = static_cast<std::int64_t>(key.morton());
      break;
    }
    rows.put(key.morton());
    rows.put(tile.first);
    ++reply.tiles;
  }
  reply.size = static_cast<std::int32_t>(reply.rows.size());
  lists_.send({static_cast<std::size_t>(&to - renderers_.data()), reply}, now.steady);
}

void RenderWorld::answer(const tile_request_t& question, Renderer& to) {
  const auto key = TileKey::from_morton(static_cast<std::uint64_t>(question.tile)).value();
  fetched.push_back(key);
  if (silent.contains(key) || !stores_answer) return;
  const auto& [version, tree] = stored.at(key);
  const Bytes bytes = encode_tile(cut_tile(tree, question.depth), {});
  constexpr std::size_t kRange = 1'500;  // Small ranges: there shall be several.
  tile_reply_t reply{};
  reply.client = question.client;
  reply.id = question.id;
  reply.tile = question.tile;
  reply.version = static_cast<std::int64_t>(version);
  reply.total = static_cast<std::int32_t>(bytes.size());
  reply.offset = question.offset;
  const auto first = std::min(static_cast<std::size_t>(question.offset), bytes.size());
  const auto part = ByteView(bytes).subspan(first, std::min(kRange, bytes.size() - first));
  reply.payload.assign(part.begin(), part.end());
  reply.size = static_cast<std::int32_t>(part.size());
  tiles_.send({static_cast<std::size_t>(&to - renderers_.data()), reply}, now.steady);
}

void RenderWorld::step(Renderer& renderer) {
  const auto number = static_cast<std::size_t>(&renderer - renderers_.data());
  auto& service = *renderer.service;
  while (!renderer.building.empty() && renderer.building.begin()->first <= now.steady) {
    service.on_built(std::move(renderer.building.extract(renderer.building.begin()).mapped()), now);
  }
  while (!renderer.painting.empty() && renderer.painting.begin()->first <= now.steady) {
    service.on_painted(std::move(renderer.painting.extract(renderer.painting.begin()).mapped()),
                       now);
  }
  auto out = service.advance(now);
  for (const auto& question : out.questions.lists) {
    list_questions_.send({number, question}, now.steady);
  }
  for (const auto& question : out.questions.tiles) {
    tile_questions_.send({number, question}, now.steady);
  }
  for (auto& job : out.builds) {
    built.emplace_back(job.key, job.depth);
    bordered += job.middle != nullptr;
    renderer.building.emplace(now.steady + setting_.build_us,
                              build(std::move(job), SensorModel::standard()));
  }
  if (out.paint) {
    renderer.painting.emplace(now.steady + paint_us, room_.paint(std::move(*out.paint)));
    renderer.painting.begin()->second.all_ms = static_cast<double>(paint_us) / 1000;
  }
  for (auto& frame : out.frames) {
    frames.push_back(std::move(frame));
    arrived_at.push_back(now.steady);
  }
}

std::int64_t RenderWorld::next_event() const {
  std::int64_t next = std::min({list_questions_.next_arrival(), tile_questions_.next_arrival(),
                                lists_.next_arrival(), tiles_.next_arrival(), told_at_ + 500'000});
  for (const Renderer& renderer : renderers_) {
    next = std::min(next, renderer.service->next_time(now.steady));
    if (!renderer.building.empty()) next = std::min(next, renderer.building.begin()->first);
    if (!renderer.painting.empty()) next = std::min(next, renderer.painting.begin()->first);
  }
  return std::max(next, now.steady + 1);
}

bool RenderWorld::run(std::int64_t us, const std::function<bool()>& done) {
  const std::int64_t end = now.steady + us;
  for (;;) {
    while (auto m = list_questions_.receive(now.steady)) answer(m->second, renderers_[m->first]);
    while (auto m = tile_questions_.receive(now.steady)) answer(m->second, renderers_[m->first]);
    while (auto m = lists_.receive(now.steady)) {
      renderers_[m->first].service->on_tiles_reply(m->second, now);
    }
    while (auto m = tiles_.receive(now.steady)) {
      renderers_[m->first].service->on_tile_reply(m->second, now);
    }
    if (now.steady >= told_at_ + 500'000) tell_statuses();
    for (std::size_t i = 0; i < renderers_.size(); ++i) {
      if (!dead.contains(i)) step(renderers_[i]);
    }
    if (done()) return true;
    const std::int64_t next = std::min(next_event(), end);
    if (now.steady >= end) return false;
    now.utime += next - now.steady;
    now.steady = next;
  }
}

std::vector<frame_t> RenderWorld::frames_of(std::int64_t client) const {
  std::vector<frame_t> theirs;
  for (const auto& out : frames) {
    if (out.frame.client == client) theirs.push_back(out.frame);
  }
  return theirs;
}

frame_t RenderWorld::frame(const render_request_t& request) {
  const std::size_t before = frames.size();
  ask(request);
  const bool came = run(60'000'000, [&] {
    return std::any_of(frames.begin() + static_cast<std::ptrdiff_t>(before), frames.end(),
                       [&](const auto& out) {
                         return out.frame.client == request.client && out.frame.id == request.id &&
                                out.frame.last == 1;
                       });
  });
  REQUIRE(came);
  return frames_of(request.client).back();
}

tile_update_t RenderWorld::change(TileKey key, const TileDelta& delta, int content) {
  auto& [version, tree] = stored.at(key);
  tree.apply(delta, SensorModel::standard());
  ++version;
  tile_update_t update{};
  update.utime = now.utime;
  update.tile = static_cast<std::int64_t>(key.morton());
  update.version = static_cast<std::int64_t>(version);
  update.content = static_cast<std::int8_t>(content != 0);
  if (content != 0) encode_delta(delta, update.payload);
  update.size = static_cast<std::int32_t>(update.payload.size());
  if (content >= 0) tell(update);
  return update;
}

void RenderWorld::tell(const tile_update_t& update) {
  for (auto& renderer : renderers_) renderer.service->on_tile_update(update, now);
}

std::vector<TileKey> RenderWorld::in_view() const {
  return tiles_in_view(camera, scene.grid(), scene.keys());
}

Image RenderWorld::painted(const Camera& seen_by, const PaintOptions& how) const {
  std::vector<RenderTree> trees;
  std::vector<PlacedTree> placed;
  trees.reserve(stored.size());
  std::map<TileKey, RenderTree> alone;
  for (const TileKey key : fetched) {
    const auto& [version, tile] = stored.at(key);
    alone.try_emplace(key, tile, version);
  }
  // In the service's order: which cells' heights are sampled depends on it (scene_heights).
  std::vector<TileKey> keys;
  for (const auto& [key, tree] : alone) keys.push_back(key);
  for (const TileKey key : tiles_in_view(seen_by, scene.grid(), keys)) {
    const RenderTree& tree = alone.at(key);
    TreesAround around(tree);
    for (const auto& [other, neighbour] : alone) {
      const auto a = key.index(), b = other.index();
      const Eigen::Vector3i offset(static_cast<int>(b[0] - a[0]), static_cast<int>(b[1] - a[1]),
                                   static_cast<int>(b[2] - a[2]));
      if (other != key && offset.cwiseAbs().maxCoeff() <= 1) around.set(offset, &neighbour);
    }
    trees.push_back(tree.with_borders(around));
    placed.push_back({key, &trees.back()});
  }
  Painting painting;
  REQUIRE(Painter(1).paint(seen_by, scene.grid(), placed, how, painting).has_value());
  return painting.image;
}

}  // namespace voxatlas::test
