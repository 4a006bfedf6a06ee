#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/renderer_roll.hpp"
#include "render/tile_asker.hpp"
#include "render/tile_directory.hpp"
#include "render/tree_cache.hpp"
#include "render/view.hpp"

namespace voxatlas {

/// One moment on both clocks, microseconds.
struct Moment {
  std::int64_t steady = 0;
  std::int64_t utime = 0;
};

struct RenderConfig {
  std::size_t cache_bytes = std::size_t{256} << 20;
  QuestionLimits limits;
  std::int32_t index = 0;     ///< Of this renderer, told in its frames.
  std::int64_t instance = 1;  ///< status_t's.
  std::size_t builds = 4;     ///< Jobs given out at once: no more, so that what matters goes first.
  /// Whether a client's stream takes another frame now.
  std::function<bool(std::int32_t reply_port, std::int64_t client)> has_room =
      [](std::int32_t, std::int64_t) { return true; };
};

/// A frame and where it goes.
struct OutgoingFrame {
  frame_t frame{};
  std::int32_t reply_port = 0;  ///< 0: to everyone, on VOXATLAS_FRAME; else by reliable stream.
};

/// Answers requests for pictures: messages, trees and pictures in; frames, questions and jobs out.
/// A state machine: it never waits, knows no network, no thread and no clock.
///
/// Clients: the newest request of each is answered (one that is already answered is not begun
///          again), clients in turn, a picture each: who asks a thousand times a second delays no
///          other. A picture that is being painted is finished and sent, unless it is cancelled.
///          A bad request is answered by a frame without picture whose `error` says why.
/// Tiles:   those in view of every client, nearest first, coarse trees before fine ones.
/// Others:  of several renderers one answers each client (RendererRoll).
/// Memory:  the cache's budget; kMaxClients requests; a further client's is refused.
/// Threads: one at a time.
class RenderService {
 public:
  static constexpr std::size_t kMaxClients = 64;
  static constexpr std::int64_t kErrorGap = 10'000;  ///< Between answers to bad requests.

  RenderService(const Grid& grid, const AskerConfig& asker, RenderConfig config);

  void on_request(const render_request_t& request, Moment now);
  void on_tile_update(const tile_update_t& update, Moment now);
  void on_status(const status_t& status, Moment now) { roll_.on_status(status, now.steady); }
  void on_tiles_reply(const tiles_reply_t& reply, Moment now);
  void on_tile_reply(const tile_reply_t& reply, Moment now);
  void on_built(BuiltTile built, Moment now);
  void on_painted(PaintedPicture picture, Moment now);
  /// A client whose stream is given up.
  void on_gone(std::int64_t client);

  /// What is to be done now. Every job comes back by on_built() or on_painted().
  struct Output {
    std::vector<OutgoingFrame> frames;
    TileAsker::Questions questions;
    std::vector<BuildJob> builds;
    std::optional<PaintJob> paint;  ///< One at a time.
  };
  Output advance(Moment now);
  /// When advance() has something to do though nothing came in.
  std::int64_t next_time(std::int64_t now) const;

  std::vector<std::pair<std::string, double>> counters(std::int64_t now) const;

 private:
  struct Client {
    std::unique_ptr<View> view;  // Null: nothing is asked.
    Pacer pacer;
    std::uint64_t served = 0;  // In which turn.
    camera_t asked_camera{};
    Sight sight;
    std::uint64_t surveyed = 0;  // The generation then, and when.
    std::int64_t surveyed_at = 0, lacking_since = 0;
    std::int32_t surveyed_place = -1;
    std::vector<TileKey> asks, coarse, fine, rough;  // Of what is missing: nearest first.
  };
  using Clients = std::map<std::int64_t, Client>;
  struct Painting {
    std::int64_t client = 0;
    std::unique_ptr<View> orphan;  // The view, where a newer request has taken its place.
    Shot shot;
    std::int64_t begun = 0;
    double fetch_ms = 0;
    bool unwanted = false;
  };

  void begin(Client& client, const render_request_t& request, Moment now);
  void drop(Client& client);
  void discard_painting(std::int64_t client);
  void refuse(const render_request_t& request, std::string why);
  void forget_clients();
  void take_arrivals(Moment now);

  void survey(Client& client, Moment now);
  void survey_tiles(Client& client, const TileDirectory::View& seen, Moment now);
  bool needs_survey(const Client& client, Moment now) const;
  void ask_for_tiles(Moment now);
  void give_builds(Output& out);
  void give_paint(Output& out, Moment now);
  bool paint_of(Clients::iterator client, Output& out, Moment now);
  void give_refusals(Output& out, Moment now);
  OutgoingFrame frame_of(const View& view, const View::Mark& mark, PaintedPicture& picture,
                         Moment now) const;

  Grid grid_;
  RenderConfig config_;
  RendererRoll roll_;
  TileDirectory directory_;
  TileAsker asker_;
  TreeCache cache_;
  Clients clients_;
  std::map<std::int64_t, OutgoingFrame> refusals_;  // By client, its latest.
  std::vector<OutgoingFrame> ready_;
  std::optional<Painting> painting_;
  std::size_t building_ = 0;
  std::uint64_t generation_ = 1;  // Grows with all that may change what is to be seen.
  std::uint64_t turn_ = 0, tickets_ = 0;
  std::int64_t refused_at_ = 0;

  struct Counts {
    std::uint64_t requests = 0, replaced = 0, refused = 0, expired = 0, elsewhere = 0, failed = 0;
    std::uint64_t frames = 0, over_budget = 0, fetched = 0, built = 0, missing = 0;
    double last_frame_ms = 0;
  } counts_;
};

}  // namespace voxatlas
