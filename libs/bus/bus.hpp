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
/// Cost:    LCM's own receive thread drains the socket; subscriptions have unlimited queues, so
/// that
///          streams are bounded by credit and not by LCM's silent drop at 30.
class Bus {
 public:
  static constexpr std::size_t kMaxPlainBytes = 60'000;
  static constexpr std::size_t kMaxFrameBytes = 160'000;

  static Result<std::unique_ptr<Bus>> create(const std::string& url);
  ~Bus();

  template <class T>
  Status publish(const std::string& channel, const T& message) {
    return publish_bytes(channel, encode_message(message));
  }

  template <class T>
  void subscribe(const std::string& channel, std::function<void(const T&)> handler) {
    subscribe_bytes(channel, [handler = std::move(handler)](ByteView bytes) -> Status {
      auto message = decode_message<T>(bytes);
      if (!message) return pass_on(message);
      handler(*message);
      return {};
    });
  }

  Status publish_bytes(const std::string& channel, const Bytes& bytes);
  void subscribe_bytes(const std::string& channel, std::function<Status(ByteView)> handler);

  int fd() const;           ///< Readable where messages wait: for poll().
  Status handle_waiting();  ///< Runs the handlers of all messages that wait now; never blocks.

  const std::string& url() const;

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
