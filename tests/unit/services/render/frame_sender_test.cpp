#include "render/frame_sender.hpp"

#include <catch2/catch.hpp>

#include "bus/channels.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a frame for everyone is published", "[render]") {
  auto bus = Bus::create("memq://").value();
  std::optional<frame_t> seen;
  bus->subscribe<frame_t>(kFrameChannel, [&](const frame_t& frame) { seen = frame; });
  FrameSender sender(*bus);
  OutgoingFrame out;
  out.frame.id = 9;
  out.frame.data = {1, 2, 3};
  out.frame.size = 3;
  REQUIRE(sender.send(out, 1).has_value());
  for (int i = 0; i < 100 && !seen; ++i) REQUIRE(bus->handle_waiting().has_value());
  REQUIRE(seen.has_value());
  REQUIRE(seen->id == 9);
  REQUIRE(seen->data == out.frame.data);
  REQUIRE(sender.links() == 0);
}

TEST_CASE("streams to clients are bounded in number, and silent ones forgotten", "[render]") {
  auto bus = Bus::create("memq://").value();
  FrameSender sender(*bus);
  const auto frame_to = [](std::int32_t index) {
    OutgoingFrame out;
    out.frame.data = Bytes(1000, 7);
    out.frame.size = 1000;
    out.reply_port = Endpoint::create(EndpointClass::kClient, index)->port_offset();
    return out;
  };
  std::int64_t now = 1'000'000;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(FrameSender::kMaxLinks); ++i) {
    REQUIRE(sender.send(frame_to(i), now).has_value());
  }
  REQUIRE(sender.send(frame_to(3), now).has_value());  // Its stream is there.
  REQUIRE(sender.links() == FrameSender::kMaxLinks);
  const auto refused = sender.send(frame_to(99), now);
  REQUIRE_FALSE(refused.has_value());
  REQUIRE(refused.error().code == ErrorCode::kUnavailable);
  REQUIRE(sender.next_poll(now) < now + FrameSender::kForget);

  now += FrameSender::kForget + 1;
  REQUIRE(sender.pump(now).has_value());
  REQUIRE(sender.links() == 0);
  REQUIRE(sender.send(frame_to(99), now).has_value());
}

TEST_CASE("a port that is no client's gets no stream", "[render]") {
  auto bus = Bus::create("memq://").value();
  FrameSender sender(*bus);
  OutgoingFrame out;
  out.reply_port = 7;
  REQUIRE(sender.send(out, 1).error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
