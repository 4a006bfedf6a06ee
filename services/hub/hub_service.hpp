#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "hub/channel_pattern.hpp"

namespace voxatlas {

struct HubConfig {
  std::size_t max_clients = 256;
  std::size_t max_client_bytes = std::size_t{16} << 20;  ///< Waiting to be sent, a client.
  std::size_t max_message_bytes = std::size_t{1} << 20;
  std::size_t max_channel_bytes = 256;
  std::size_t max_subscriptions = 1024;  ///< Of a client.
};

/// The hub of LCM's tcpq protocol, without sockets: bytes of clients in, bytes for clients out.
///
/// Source:  LCM's tcpq provider: both sides send a magic number and a version (0x0100), then the
///          client sends: type (1 publish, 2 subscribe, 3 unsubscribe), channel length, channel,
///          and for a publish data length and data; the hub sends publishes alike. All numbers are
///          uint32, big endian.
/// Slow:    a client that does not read loses what exceeds max_client_bytes, counted, as it would
///          on multicast; nobody waits for it.
/// Errors:  a client that breaks the protocol or its bounds is to be closed; the others go on.
/// Threads: one at a time.
class HubService {
 public:
  using ClientId = std::int64_t;

  explicit HubService(const HubConfig& config) : config_(config) {}

  /// Errors: kUnavailable where there are as many as may be.
  Result<ClientId> connect();
  void disconnect(ClientId client);

  /// What a client has sent, in any pieces. Errors: kCorrupt, kOutOfRange: close it.
  Status receive(ClientId client, ByteView bytes);

  /// A message of the hub's own, to all who asked for its channel.
  void say(std::string_view channel, ByteView data);

  /// What waits for a client, in order; valid until the next call that is not const.
  std::vector<ByteView> waiting(ClientId client, std::size_t most_pieces) const;
  /// So many bytes of that were taken.
  void sent(ClientId client, std::size_t bytes);
  bool has_waiting(ClientId client) const;

  struct Counters {
    std::uint64_t messages = 0, delivered = 0, dropped = 0, clients = 0;
  };
  const Counters& counters() const { return counters_; }
  std::size_t waiting_bytes() const;  ///< For all clients together.

 private:
  /// Owned by every client that it waits for; it dies with the last.
  using Frame = std::shared_ptr<const Bytes>;

  struct Client {
    bool greeted = false;
    Bytes in;  ///< The beginning of a message.
    std::map<std::string, std::pair<ChannelPattern, int>> patterns;  ///< With how many ask so.
    std::map<std::string, bool, std::less<>> wanted;                 ///< Channels asked for before.
    std::deque<Frame> out;
    std::size_t out_bytes = 0;
    std::size_t first_sent = 0;  ///< Bytes of out.front() that are gone already.
  };

  Result<std::size_t> take_message(Client& client, ByteView bytes);
  Status greet(Client& client, std::uint32_t magic, std::uint32_t version) const;
  Status subscribe(Client& client, const std::string& pattern) const;
  static void unsubscribe(Client& client, const std::string& pattern);
  void publish(ByteView message, std::string_view channel);
  static bool wants(Client& client, std::string_view channel);

  HubConfig config_;
  std::map<ClientId, Client> clients_;
  ClientId last_client_ = 0;
  Counters counters_;
};

}  // namespace voxatlas
