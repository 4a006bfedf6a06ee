#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/stream_link.hpp"
#include "render/render_service.hpp"

namespace voxatlas {

/// Sends frames: to everyone, or by a reliable stream to who asked.
///
/// Streams live until their client has taken everything, or has not been heard of for kForget.
/// Memory: kMaxLinks streams of kMostFrames each; a frame for a further client, or one whose stream
///         is full, is refused.
/// Threads: one at a time.
class FrameSender {
 public:
  static constexpr std::size_t kMaxLinks = 32;
  static constexpr std::int64_t kMostFrames = 3;       ///< Under way to a client.
  static constexpr std::int64_t kForget = 15'000'000;  ///< Microseconds.

  explicit FrameSender(Bus& bus) : bus_(bus) {}

  /// Whether send() would take a frame now: a client that is slow gets fewer, not later ones.
  bool has_room(std::int32_t reply_port, std::int64_t client) const;
  /// Errors: kUnavailable where there is no room for it; the bus's.
  Status send(const OutgoingFrame& out, std::int64_t now);

  /// Moves the streams on. Errors: the bus's.
  Status pump(std::int64_t now);
  std::int64_t next_poll(std::int64_t now) const;
  /// Clients whose frames were not taken: they are gone, and so are the frames.
  std::vector<std::int64_t> take_gone() { return std::exchange(gone_, {}); }
  std::size_t links() const { return links_.size(); }
  std::vector<StreamProducer*> producers() const;

 private:
  struct Link {
    std::unique_ptr<OutLink> out;
    std::int64_t last_offer = 0;
  };
  static bool done(const Link& link, std::int64_t now);
  static std::int64_t under_way(const Link& link);
  Result<Link*> link_to(std::int32_t reply_port, std::int64_t client);

  Bus& bus_;
  std::map<std::pair<std::int32_t, std::int64_t>, Link> links_;  // By port and client.
  std::vector<std::int64_t> gone_;
};

}  // namespace voxatlas
