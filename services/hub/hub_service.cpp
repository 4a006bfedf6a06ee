#include "hub/hub_service.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.hpp"
#include "base/log.hpp"

namespace voxatlas {
namespace {

constexpr std::uint32_t kServerMagic = 0x287617fa;
constexpr std::uint32_t kClientMagic = 0x287617fb;
constexpr std::uint32_t kProtocolVersion = 0x0100;
constexpr std::uint32_t kPublish = 1;
constexpr std::uint32_t kSubscribe = 2;
constexpr std::uint32_t kUnsubscribe = 3;
constexpr std::size_t kWord = 4;
constexpr std::size_t kMaxRemembered = 4096;  ///< Channels whose match is kept, a client.

std::uint32_t word_at(ByteView bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < kWord; ++i) value = value << 8 | bytes[at + i];
  return value;
}

void put_word(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

}  // namespace

Result<HubService::ClientId> HubService::connect() {
  if (clients_.size() >= config_.max_clients) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{} clients are all there may be", config_.max_clients));
  }
  auto& client = clients_[++last_client_];
  Bytes greeting;
  put_word(greeting, kServerMagic);
  put_word(greeting, kProtocolVersion);
  client.out_bytes = greeting.size();
  client.out.push_back(std::make_shared<const Bytes>(std::move(greeting)));
  counters_.clients = clients_.size();
  return last_client_;
}

void HubService::disconnect(ClientId client) {
  clients_.erase(client);
  counters_.clients = clients_.size();
}

Status HubService::receive(ClientId id, ByteView bytes) {
  auto& client = clients_.at(id);
  // Only the piece of a message that has not come whole is copied.
  if (!client.in.empty()) {
    client.in.insert(client.in.end(), bytes.begin(), bytes.end());
    bytes = client.in;
  }
  while (!bytes.empty()) {
    auto taken = take_message(client, bytes);
    if (!taken) return pass_on(taken);
    if (*taken == 0) break;
    bytes = bytes.subspan(*taken);
  }
  Bytes rest(bytes.begin(), bytes.end());
  client.in = std::move(rest);
  return {};
}

/// Takes one message from the front; returns how long it was, 0 where it is not whole yet.
Result<std::size_t> HubService::take_message(Client& client, ByteView bytes) {
  if (bytes.size() < 2 * kWord) return 0;
  const auto type = word_at(bytes, 0);
  const auto channel_bytes = word_at(bytes, kWord);
  if (!client.greeted) {
    if (auto status = greet(client, type, channel_bytes); !status) return pass_on(status);
    return 2 * kWord;
  }
  if (type < kPublish || type > kUnsubscribe) {
    return fail(ErrorCode::kCorrupt, fmt::format("message of unknown type {}", type));
  }
  if (channel_bytes > config_.max_channel_bytes) {
    return fail(ErrorCode::kOutOfRange, fmt::format("channel name of {} bytes, at most {}",
                                                    channel_bytes, config_.max_channel_bytes));
  }
  std::size_t size = 2 * kWord + channel_bytes;
  if (bytes.size() < size) return 0;
  const auto channel = as_text(bytes.subspan(2 * kWord, channel_bytes));
  if (type == kSubscribe) {
    if (auto status = subscribe(client, std::string(channel)); !status) return pass_on(status);
    return size;
  }
  if (type == kUnsubscribe) {
    unsubscribe(client, std::string(channel));
    return size;
  }
  if (bytes.size() < size + kWord) return 0;
  const auto data_bytes = word_at(bytes, size);
  if (data_bytes > config_.max_message_bytes) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("message of {} bytes on {}, at most {}", data_bytes, channel,
                            config_.max_message_bytes));
  }
  size += kWord + data_bytes;
  if (bytes.size() < size) return 0;
  publish(bytes.first(size), channel);
  return size;
}

Status HubService::greet(Client& client, std::uint32_t magic, std::uint32_t version) const {
  if (magic != kClientMagic || version != kProtocolVersion) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("no LCM client: it greets with {:#x}, version {:#x}", magic, version));
  }
  client.greeted = true;
  return {};
}

Status HubService::subscribe(Client& client, const std::string& text) const {
  client.wanted.clear();
  if (const auto known = client.patterns.find(text); known != client.patterns.end()) {
    ++known->second.second;
    return {};
  }
  if (client.patterns.size() >= config_.max_subscriptions) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("more than {} subscriptions", config_.max_subscriptions));
  }
  auto pattern = ChannelPattern::parse(text);
  if (!pattern) return pass_on(pattern);
  client.patterns.emplace(text, std::pair(std::move(*pattern), 1));
  return {};
}

void HubService::unsubscribe(Client& client, const std::string& text) {
  client.wanted.clear();
  const auto known = client.patterns.find(text);
  if (known != client.patterns.end() && --known->second.second == 0) client.patterns.erase(known);
}

bool HubService::wants(Client& client, std::string_view channel) {
  if (const auto known = client.wanted.find(channel); known != client.wanted.end()) {
    return known->second;
  }
  if (client.wanted.size() >= kMaxRemembered) client.wanted.clear();
  const bool wanted = std::ranges::any_of(
      client.patterns, [&](const auto& entry) { return entry.second.first.matches(channel); });
  client.wanted.emplace(channel, wanted);
  return wanted;
}

void HubService::publish(ByteView message, std::string_view channel) {
  ++counters_.messages;
  Frame frame;
  for (auto& [id, client] : clients_) {
    if (!client.greeted || !wants(client, channel)) continue;
    if (client.out_bytes + message.size() > config_.max_client_bytes) {
      ++counters_.dropped;
      continue;
    }
    if (frame == nullptr) frame = std::make_shared<const Bytes>(message.begin(), message.end());
    client.out.push_back(frame);
    client.out_bytes += message.size();
    ++counters_.delivered;
  }
}

void HubService::say(std::string_view channel, ByteView data) {
  Bytes message;
  put_word(message, kPublish);
  put_word(message, static_cast<std::uint32_t>(channel.size()));
  message.insert(message.end(), channel.begin(), channel.end());
  put_word(message, static_cast<std::uint32_t>(data.size()));
  message.insert(message.end(), data.begin(), data.end());
  publish(message, channel);
}

std::size_t HubService::waiting_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, client] : clients_) bytes += client.out_bytes;
  return bytes;
}

std::vector<ByteView> HubService::waiting(ClientId id, std::size_t most_pieces) const {
  const auto& client = clients_.at(id);
  std::vector<ByteView> pieces;
  for (const auto& frame : client.out) {
    if (pieces.size() == most_pieces) break;
    ByteView bytes(*frame);
    if (pieces.empty()) bytes = bytes.subspan(client.first_sent);
    pieces.push_back(bytes);
  }
  return pieces;
}

void HubService::sent(ClientId id, std::size_t bytes) {
  auto& client = clients_.at(id);
  VOX_CHECK(bytes <= client.out_bytes);
  client.out_bytes -= bytes;
  bytes += client.first_sent;
  while (!client.out.empty() && bytes >= client.out.front()->size()) {
    bytes -= client.out.front()->size();
    client.out.pop_front();
  }
  client.first_sent = bytes;
}

bool HubService::has_waiting(ClientId id) const { return !clients_.at(id).out.empty(); }

}  // namespace voxatlas
