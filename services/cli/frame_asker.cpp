#include "cli/frame_asker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/progress.hpp"

namespace voxatlas {
namespace {

/// Longer than a renderer waits for tiles that do not come.
constexpr std::int64_t kAskAgain = 4'000'000, kAskAgainAtFirst = 500'000;

/// One question and what has come of it.
class Asking {
 public:
  Asking(ModelClient& client, render_request_t request, double timeout,
         const std::function<Status(const frame_t&)>& take)
      : client_(client),
        request_(std::move(request)),
        patience_(static_cast<std::int64_t>(timeout * 1e6)),
        take_(take) {}

  Status run();

 private:
  void on_frame(const frame_t& frame);
  Result<std::int64_t> work(std::int64_t now);
  Status ask(std::int64_t now);

  ModelClient& client_;
  render_request_t request_;
  std::int64_t patience_;
  const std::function<Status(const frame_t&)>& take_;
  std::int64_t heard_at_ = 0, ask_at_ = 0, interval_ = kAskAgainAtFirst;
  std::int64_t sequence_ = -1;  // The last that was taken, of this id.
  std::int64_t frames_ = 0;
  bool done_ = false;
  Status taken_;
  Progress progress_;
};

void Asking::on_frame(const frame_t& frame) {
  if (frame.client != request_.client || frame.id != request_.id || done_) return;
  if (frame.sequence <= sequence_) return;  // Two renderers answered, or one twice.
  sequence_ = frame.sequence;
  heard_at_ = steady_utime();
  ask_at_ = heard_at_ + kAskAgain;
  interval_ = kAskAgain;
  done_ = frame.last == 1;
  taken_ = frame.error.empty() ? take_(frame) : fail(ErrorCode::kInvalid, frame.error);
  if (!taken_) done_ = true;
  ++frames_;
  if (request_.path_size > 0) request_.first = frame.place + 1;
}

Status Asking::ask(std::int64_t now) {
  interval_ = std::min(2 * interval_, kAskAgain);
  ask_at_ = now + interval_;
  if (frames_ > 0) {  // Whoever answered is gone: another question, from where that had come to.
    ++request_.id;
    sequence_ = -1;
    frames_ = 0;
  }
  request_.utime = utime_now();
  if (request_.kind == 0) request_.deadline = request_.utime + patience_ - (now - heard_at_);
  auto sent = client_.bus().publish(kRenderRequestChannel, request_);
  if (!sent && sent.error().code == ErrorCode::kUnavailable) return {};  // The hub is away.
  return sent;
}

Result<std::int64_t> Asking::work(std::int64_t now) {
  for (const auto& message : client_.in().consumer().take()) {
    client_.in().consumer().commit(message.session, message.number);
    if (message.kind != MessageKind::kFrame) continue;
    if (auto frame = decode_message<frame_t>(message.payload)) on_frame(*frame);
  }
  if (auto pumped = client_.in().pump(now); !pumped) return pass_on(pumped);
  if (done_) return now;
  if (now - heard_at_ > patience_) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("no picture came within {} s: is a render service running? "
                            "(voxatlas watch status)",
                            static_cast<double>(patience_) / 1e6));
  }
  if (now >= ask_at_) {
    if (auto asked = ask(now); !asked) return pass_on(asked);
  }
  progress_.say(request_.path_size > 0 ? fmt::format("{} pictures", request_.first)
                                       : "waiting for the picture");
  return std::min(ask_at_, client_.in().consumer().next_poll(now));
}

Status Asking::run() {
  heard_at_ = steady_utime();
  const auto heard = client_.bus().subscribe<frame_t>(
      kFrameChannel, [this](const frame_t& frame) { on_frame(frame); });
  ServiceLoop loop;
  loop.buses = {&client_.bus(), &client_.in().port()};
  loop.finished = [this] { return done_; };
  loop.work = [this](std::int64_t now) { return work(now); };
  auto ended = loop.run();
  client_.bus().unsubscribe(heard);
  if (!ended) return ended;
  if (!done_) return fail(ErrorCode::kUnavailable, "stopped");
  return taken_;
}

}  // namespace

camera_t to_message(const Camera& camera) {
  camera_t message{};
  const Lens& lens = camera.lens();
  message.projection = camera.orthographic() ? 1 : 0;
  for (int axis = 0; axis < 3; ++axis) message.position[axis] = camera.position()[axis];
  const auto& turn = camera.orientation();
  const double wxyz[] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy(std::begin(wxyz), std::end(wxyz), message.orientation);
  message.fx = lens.fx;
  message.fy = lens.fy;
  message.cx = lens.cx;
  message.cy = lens.cy;
  message.width = lens.width;
  message.height = lens.height;
  message.near_range = lens.near_range;
  message.far_range = lens.far_range;
  return message;
}

Status ask_for_frames(ModelClient& client, render_request_t request, double timeout,
                      const std::function<Status(const frame_t&)>& take) {
  return Asking(client, std::move(request), timeout, take).run();
}

}  // namespace voxatlas
