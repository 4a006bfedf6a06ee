#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "bus/wire.hpp"

namespace voxatlas {

/// One LCM connection: typed publish and subscribe on one URL.
///
/// Errors:  create: kUnavailable where LCM refuses the URL or has no route, saying which. publish:
///          kOutOfRange for a message LCM would lose without a word (above kMaxPlainBytes, or
///          kMaxFrameBytes for frames), kIo where LCM says no. A message that does not decode is
///          counted, logged (at most once a second) and dropped; a handler that throws is a bug.
/// Threads: one at a time for everything, handlers run inside handle().
///          An exception that leaves a handler comes out of handle_waiting(), not through LCM's C.
///          A lost hub (tcpq) is no error but like lost datagrams: publish says kUnavailable until
///          handle_waiting() has found it again; it tries twice a second.
/// Channels are literal names, not LCM's patterns.
/// Cost:    LCM's own receive thread drains the socket; a subscription holds up to
///          kQueuedMessages, above any stream's credit, where LCM's own limit drops at 30. At a
///          port (create_port) there is neither thread nor queue, only the kernel's buffer.
class Bus {
 public:
  static constexpr std::size_t kMaxPlainBytes = 60'000;
  static constexpr std::size_t kMaxFrameBytes = 160'000;
  static constexpr int kQueuedMessages = 2000;
  using Subscription = std::int64_t;

  static Result<std::unique_ptr<Bus>> create(const std::string& url);
  /// The bus at an endpoint's own multicast port, where a consumer takes in gigabytes: it receives
  /// without LCM (PortSocket), and only messages of one datagram, as all but frames are.
  static Result<std::unique_ptr<Bus>> create_port(const std::string& url);
  ~Bus();

  template <class T>
  Status publish(const std::string& channel, const T& message) {
    return publish_bytes(channel, encode_message(message));
  }

  template <class T>
  Subscription subscribe(const std::string& channel, std::function<void(const T&)> handler) {
    return subscribe_bytes(channel, [handler = std::move(handler)](ByteView bytes) -> Status {
      auto message = decode_message<T>(bytes);
      if (!message) return pass_on(message);
      handler(*message);
      return {};
    });
  }

  Status publish_bytes(const std::string& channel, const Bytes& bytes);
  Subscription subscribe_bytes(const std::string& channel, std::function<Status(ByteView)> handler);
  /// From now on its handler is not called; fine inside a handler, even its own.
  void unsubscribe(Subscription subscription);

  int fd() const;  ///< Readable where messages wait: for poll(). -1 while a hub is lost.
  /// Runs the handlers of the messages that wait now, some thousand at most; never blocks.
  Status handle_waiting();

  const std::string& url() const;  ///< In full, defaults filled in.
  /// Whether endpoints have ports of their own here (multicast); elsewhere they share this bus.
  bool has_ports() const;

  struct Counters {
    std::uint64_t received = 0, received_bytes = 0, undecodable = 0;
    std::uint64_t published = 0, published_bytes = 0;
  };
  const Counters& counters() const;

 private:
  struct State;
  explicit Bus(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
