#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/endpoint.hpp"
#include "bus/stream_consumer.hpp"
#include "bus/stream_producer.hpp"

namespace voxatlas {

/// A StreamProducer on a real bus: chunks go to the consumer's port and channel, acknowledgements
/// come from the main bus. pump() as often as convenient and by next_poll() at the latest.
class OutLink {
 public:
  /// `bus` carries the acknowledgements and must outlive the link.
  static Result<std::unique_ptr<OutLink>> create(Bus& bus, const Endpoint& consumer,
                                                 const StreamConfig& config);
  ~OutLink();

  StreamProducer& producer();
  Status pump(std::int64_t now);

 private:
  struct State;
  explicit OutLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A StreamConsumer on a real bus: it listens on its endpoint's own port.
class InLink {
 public:
  static Result<std::unique_ptr<InLink>> create(Bus& bus, const Endpoint& self,
                                                ConsumerConfig config);
  ~InLink();

  StreamConsumer& consumer();
  Bus& port();  ///< The endpoint's own connection: its fd is for poll(); replies come here too.
  Status pump(std::int64_t now);

 private:
  struct State;
  explicit InLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
