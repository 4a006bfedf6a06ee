#include "render/frame_sender.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "bus/channels.hpp"

namespace voxatlas {

std::int64_t FrameSender::under_way(const Link& link) {
  const StreamProducer& producer = link.out->producer();
  return producer.offered_messages() - producer.committed_messages();
}

bool FrameSender::has_room(std::int32_t reply_port, std::int64_t client) const {
  if (reply_port == 0) return true;
  const auto found = links_.find({reply_port, client});
  return found == links_.end() ? links_.size() < kMaxLinks : under_way(found->second) < kMostFrames;
}

Status FrameSender::send(const OutgoingFrame& out, std::int64_t now) {
  if (out.reply_port == 0) return bus_.publish(kFrameChannel, out.frame);
  auto link = link_to(out.reply_port, out.frame.client);
  if (!link) return pass_on(link);
  StreamProducer& producer = (*link)->out->producer();
  if (under_way(**link) >= kMostFrames || !producer.has_room()) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("client at port {}: its stream is full", out.reply_port));
  }
  producer.offer(MessageKind::kFrame, encode_message(out.frame));
  (*link)->last_offer = now;
  return (*link)->out->pump(now);
}

Result<FrameSender::Link*> FrameSender::link_to(std::int32_t reply_port, std::int64_t client) {
  if (const auto found = links_.find({reply_port, client}); found != links_.end())
    return &found->second;
  if (links_.size() >= kMaxLinks) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("client at port {}: {} others have streams already", reply_port,
                            links_.size()));
  }
  auto endpoint = Endpoint::client_at(reply_port);
  if (!endpoint) return pass_on(endpoint);
  StreamConfig config;
  config.client = client;  // Clients may share a port: each takes only streams made for it.
  auto out = OutLink::create(bus_, *endpoint, config);
  if (!out) return pass_on(out);
  return &links_.emplace(std::pair{reply_port, client}, Link{std::move(*out), 0}).first->second;
}

/// A stream is kept a little after its last message, as the next one may follow.
bool FrameSender::done(const Link& link, std::int64_t now) {
  const StreamProducer& producer = link.out->producer();
  const std::int64_t heard = std::max(producer.last_heard(), link.last_offer);
  return now - heard > kForget;
}

Status FrameSender::pump(std::int64_t now) {
  std::erase_if(links_, [&](const auto& link) {
    if (!done(link.second, now)) return false;
    if (under_way(link.second) > 0) gone_.push_back(link.first.second);
    return true;
  });
  for (auto& [port, link] : links_) {
    if (auto pumped = link.out->pump(now); !pumped) return pumped;
  }
  return {};
}

std::vector<StreamProducer*> FrameSender::producers() const {
  std::vector<StreamProducer*> result;
  for (const auto& [port, link] : links_) result.push_back(&link.out->producer());
  return result;
}

std::int64_t FrameSender::next_poll(std::int64_t now) const {
  std::int64_t next = std::numeric_limits<std::int64_t>::max();
  for (const auto& [port, link] : links_) {
    next = std::min(next, link.out->producer().next_poll(now));
  }
  return next;
}

}  // namespace voxatlas
