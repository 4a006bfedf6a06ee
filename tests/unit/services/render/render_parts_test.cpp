#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include "../../render/scene.hpp"
#include "base/bytes.hpp"
#include "render/camera_path.hpp"
#include "render/crew.hpp"
#include "render/renderer_roll.hpp"
#include "render/tile_asker.hpp"
#include "render/tile_directory.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a page of tiles is read row by row, and a false one refused", "[render]") {
  const Grid grid = Grid::standard();
  tiles_reply_t page{};
  ByteWriter rows(page.rows);
  for (const std::uint64_t key : {5u, 77u}) {
    rows.put<std::uint64_t>(key);
    rows.put<std::uint64_t>(key + 1);
  }
  page.tiles = 2;
  page.size = static_cast<std::int32_t>(page.rows.size());
  const auto listed = listed_tiles(page, grid);
  REQUIRE(listed.has_value());
  REQUIRE(listed->size() == 2);
  REQUIRE((*listed)[1].key.morton() == 77);
  REQUIRE((*listed)[1].version == 78);

  auto wrong = page;
  wrong.tiles = 3;
  REQUIRE(listed_tiles(wrong, grid).error().code == ErrorCode::kCorrupt);
  wrong.tiles = -1;
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
  wrong = page;
  wrong.details = 1;
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
  wrong = page;
  wrong.rows[7] = 0xff;  // A key above 2^63.
  REQUIRE_FALSE(listed_tiles(wrong, grid).has_value());
}

TEST_CASE("a store that goes round in circles is not followed", "[render]") {
  TileAsker asker(Grid::standard(), {1, 7, 400, 3});
  asker.list({{0, 0, 0}, {15, 15, 15}}, 0);
  auto questions = asker.poll(0);
  REQUIRE(questions.lists.size() == 1);
  tiles_reply_t reply{};
  reply.client = 7;
  reply.id = questions.lists[0].id;
  reply.next = 0;
  asker.on_tiles_reply(reply, 10);
  REQUIRE(asker.refused() == 1);
  REQUIRE(asker.next_poll() == INT64_MAX);
}

TEST_CASE("what does not come is asked for again, more and more seldom, then given up",
          "[render]") {
  TileAsker asker(Grid::standard(), {1, 7, 400, 2});
  const TileKey key = TileKey::from_morton(5).value();
  asker.want(
      {{key, 4}, {TileKey::from_morton(6).value(), 7}, {TileKey::from_morton(7).value(), 7}});
  std::vector<std::int64_t> asked;
  for (std::int64_t now = 0; now < 4'000'000; now += 10'000) {
    for (const auto& question : asker.poll(now).tiles) {
      REQUIRE(question.client == 7);
      REQUIRE(question.depth == (question.tile == 5 ? 4 : 7));
      if (question.tile == 5) asked.push_back(now / 1000);
    }
  }
  REQUIRE(asked == std::vector<std::int64_t>{0, 100, 300, 700, 1500, 2500});
  REQUIRE_FALSE(asker.asking_for(key));
}

TEST_CASE("a directory lists by blocks, and again after a second", "[render][oracle]") {
  const test::Scene scene = test::street_scene();
  const Camera camera = scene.camera({-20, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200)).value();
  TileDirectory directory(scene.grid());
  auto seen = directory.look(camera, 5'000'000).value();
  REQUIRE(seen.listed_at == 0);
  REQUIRE(seen.to_list.has_value());
  REQUIRE(seen.tiles.empty());
  std::vector<ListedTile> tiles;
  for (const TileKey key : scene.keys()) tiles.push_back({key, 3});
  directory.take(*seen.to_list, tiles, 5'000'000);
  seen = directory.look(camera, 5'000'001).value();
  REQUIRE(seen.listed_at == 5'000'000);
  REQUIRE_FALSE(seen.to_list.has_value());
  REQUIRE(seen.tiles == tiles_in_view(camera, scene.grid(), scene.keys()));
  REQUIRE(directory.version(seen.tiles[0]) == 3);
  REQUIRE(directory.look(camera, 6'000'000)->to_list.has_value());
  REQUIRE(directory.look(camera, 6'000'000)->listed_at == 5'000'000);

  // Beside it another view, which is asked for by itself; the first is still known.
  const Camera far = scene.camera({3000, 0, 2}, {3030, 0, 2}, Lens::of_view(60, 320, 200)).value();
  const auto other = directory.look(far, 5'500'000).value();
  REQUIRE(other.to_list.has_value());
  directory.take(*other.to_list, {}, 5'500'000);
  REQUIRE_FALSE(directory.look(camera, 5'500'000)->to_list.has_value());
}

TEST_CASE("a directory keeps the highest version it heard of, of blocks it lists", "[render]") {
  const test::Scene scene = test::street_scene();
  const TileKey key = scene.keys().front();
  TileDirectory directory(scene.grid());
  REQUIRE_FALSE(directory.update(key, 9, 1));
  REQUIRE(directory.version(key) == 0);
  const Camera camera = scene.camera({-20, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200)).value();
  const auto range = directory.look(camera, 1)->to_list.value();
  directory.take(range, {{key, 3}}, 1);
  REQUIRE(directory.update(key, 5, 1));
  REQUIRE(directory.update(key, 4, 1));
  REQUIRE(directory.version(key) == 5);
  directory.take(range, {{key, 4}}, 2);  // Listed before the update.
  REQUIRE(directory.version(key) == 5);
  directory.take(range, {{key, 4}}, 2 + TileDirectory::kBelieved);  // Nobody has a 5.
  REQUIRE(directory.version(key) == 4);
  REQUIRE_FALSE(
      directory.update(key, 6, 3 + 2 * TileDirectory::kBelieved));  // Nobody looks any more.
}

TEST_CASE("a view of too much of the world is refused", "[render]") {
  const test::Scene scene = test::street_scene();
  Lens lens = Lens::of_view(60, 8192, 1);
  lens.fx = 1e-3;
  lens.far_range = 2000;
  const auto camera = scene.camera({0, 0, 2}, {30, 0, 2}, lens);
  if (!camera) return;  // The camera itself is.
  TileDirectory directory(scene.grid());
  const auto seen = directory.look(*camera, 1);
  REQUIRE((seen.has_value() || seen.error().code == ErrorCode::kOutOfRange));
}

TEST_CASE("a path is walked at an even pace between its rows", "[render]") {
  const test::Scene scene = test::street_scene();
  const Lens lens = Lens::of_view(60, 320, 200);
  const std::array cameras = {scene.camera({0, 0, 2}, {30, 0, 2}, lens).value(),
                              scene.camera({10, 0, 2}, {10, 30, 2}, lens).value(),
                              scene.camera({10, 20, 2}, {10, 50, 2}, lens).value()};
  Bytes bytes;
  ByteWriter rows(bytes);
  const double seconds[] = {0, 1, 3};
  for (std::size_t i = 0; i < 3; ++i) {
    rows.put(seconds[i]);
    for (const double x : cameras[i].position()) rows.put(x);
    const auto& q = cameras[i].orientation();
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) rows.put(x);
  }
  const auto path = CameraPath::create(bytes, lens).value();
  REQUIRE(path.places(10) == 31);
  REQUIRE(path.places(0.1) == 1);
  const auto away = [&](double at, const Camera& camera) {
    return (path.at(at).position() - camera.position()).norm();
  };
  REQUIRE(away(0, cameras[0]) < 1e-6);
  REQUIRE(away(0.5, cameras[0]) == Approx(5));
  REQUIRE(away(1, cameras[1]) < 1e-6);
  REQUIRE(away(2, cameras[1]) == Approx(10));
  REQUIRE(away(99, cameras[2]) < 1e-6);
  REQUIRE(path.at(0.5).orientation().angularDistance(cameras[0].orientation()) ==
          Approx(path.at(0.5).orientation().angularDistance(cameras[1].orientation())));
  for (const double wrong : {0.5, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    Bytes bad = bytes;
    std::memcpy(bad.data() + 128, &wrong, sizeof wrong);  // The third row does not ascend.
    REQUIRE_FALSE(CameraPath::create(bad, lens).has_value());
  }
  REQUIRE_FALSE(CameraPath::create({}, lens).has_value());
}

status_t status_of(std::int64_t instance, int ready) {
  status_t status{};
  status.service = "render";
  status.instance = instance;
  status.ready = static_cast<std::int8_t>(ready);
  return status;
}

TEST_CASE("renderers agree who answers, and few clients change hands", "[render][oracle]") {
  std::map<std::int64_t, RendererRoll> rolls;
  for (std::int64_t i = 1; i <= 5; ++i) rolls.emplace(i, RendererRoll(i));
  std::set<std::int64_t> alive;
  std::map<std::int64_t, std::int64_t> before;
  std::int64_t now = 0;
  const auto who = [&](std::int64_t client) {
    std::int64_t found = 0;
    for (const std::int64_t i : alive) {
      if (!rolls.at(i).answers(client, now)) continue;
      REQUIRE(found == 0);
      found = i;
    }
    REQUIRE(found != 0);
    return found;
  };
  for (std::int64_t newest = 1; newest <= 5; ++newest) {
    alive.insert(newest);
    now += 100'000;
    for (const std::int64_t from : alive) {
      for (const std::int64_t to : alive) rolls.at(to).on_status(status_of(from, 1), now);
    }
    for (std::int64_t client = 1; client <= 500; ++client) {
      const std::int64_t found = who(client);
      const bool stayed = before[client] == found || found == newest;
      REQUIRE(stayed);
      before[client] = found;
    }
  }
  // Number 2 says that it stops, number 3 is silent.
  now += 1'000'000;
  for (const std::int64_t from : {1, 4, 5}) {
    for (auto& [i, roll] : rolls) roll.on_status(status_of(from, 1), now);
  }
  for (auto& [i, roll] : rolls) roll.on_status(status_of(2, 0), now);
  now += RendererRoll::kAlive - 900'000;
  alive = {1, 4, 5};
  for (std::int64_t client = 1; client <= 500; ++client) {
    const std::int64_t found = who(client);
    if (before[client] != 2 && before[client] != 3) REQUIRE(found == before[client]);
  }
  REQUIRE(rolls.at(1).alive(now) == 3);
}

TEST_CASE("a crew does every job, and the loop is told", "[render]") {
  Crew<int, int> crew({[](int job) { return 2 * job; }, [](int job) { return 2 * job; }});
  std::set<int> left;
  for (int i = 0; i < 1000; ++i) {
    left.insert(2 * i);
    crew.submit(i);
  }
  while (!left.empty()) {
    for (const int done : crew.take()) REQUIRE(left.erase(done) == 1);
  }
}

}  // namespace
}  // namespace voxatlas
