#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "../../render/scene.hpp"
#include "bus/endpoint.hpp"
#include "render/camera_message.hpp"
#include "render/render_service.hpp"
#include "support/sim_wire.hpp"

namespace voxatlas::test {

/// Renderers, tile stores and the wires between them, without a network, a thread or a clock: jobs
/// are done for real, but last as long as the test says. Simulated microseconds.
class RenderWorld {
 public:
  struct Setting {
    RenderConfig config;
    WireFaults faults;  ///< Of questions and answers.
    int renderers = 1;
    std::int64_t build_us = 2'000, paint_us = 20'000;
  };
  RenderWorld() : RenderWorld(Setting()) {}
  explicit RenderWorld(const Setting& setting);

  /// A PNG by stream, without a budget.
  render_request_t request() const;
  /// The same for everyone, as a JPEG.
  render_request_t broadcast() const;
  void ask(const render_request_t& request);

  /// Runs until `done` or so much later. Returns whether it is done.
  bool run(
      std::int64_t us, const std::function<bool()>& done = [] { return false; });
  /// Asks, and runs until a frame of this request says that it is the last.
  frame_t frame(const render_request_t& request);
  std::vector<frame_t> frames_of(std::int64_t client) const;

  /// The store's tile gets another version; everyone is told with its delta (1), or that it has
  /// (0), or nobody (-1): what is returned tells of it.
  tile_update_t change(TileKey key, const TileDelta& delta, int content);
  void tell(const tile_update_t& update);

  /// What a renderer would paint that has the stores' tiles: the oracle.
  Image painted(const Camera& camera, const PaintOptions& how = {}) const;
  std::vector<TileKey> in_view() const;

  Moment now{1'000'000, 1'700'000'000'000'000};
  Scene scene = street_scene();
  Camera camera = scene.camera({-20, 0, 2}, {30, 0, 2}, Lens::of_view(60, 320, 200)).value();
  std::vector<OutgoingFrame> frames;
  std::vector<std::int64_t> arrived_at;        ///< Of each frame, steady.
  std::vector<std::pair<TileKey, int>> built;  ///< And at which depth.
  int bordered = 0;                            ///< Jobs that only looked across borders.
  std::vector<TileKey> fetched;
  std::set<TileKey> silent;    ///< Tiles that never come.
  std::set<std::size_t> dead;  ///< Renderers.
  bool stores_answer = true;
  int listed = 0;
  std::map<TileKey, std::pair<std::uint64_t, TileTree>> stored;
  std::int64_t paint_us;

 private:
  struct Renderer {
    std::unique_ptr<RenderService> service;
    std::multimap<std::int64_t, BuiltTile> building;
    std::multimap<std::int64_t, PaintedPicture> painting;
  };
  void step(Renderer& renderer);
  void answer(const tiles_request_t& question, Renderer& to);
  void answer(const tile_request_t& question, Renderer& to);
  std::int64_t next_event() const;
  void tell_statuses();

  Setting setting_;
  std::mt19937_64 rng_;
  PaintRoom room_;
  std::vector<Renderer> renderers_;
  // A wire each way for each kind; the renderer goes with the message.
  SimWire<std::pair<std::size_t, tiles_request_t>> list_questions_;
  SimWire<std::pair<std::size_t, tile_request_t>> tile_questions_;
  SimWire<std::pair<std::size_t, tiles_reply_t>> lists_;
  SimWire<std::pair<std::size_t, tile_reply_t>> tiles_;
  std::int64_t told_at_ = 0;
};

}  // namespace voxatlas::test
