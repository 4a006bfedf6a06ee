#include "bus/stream_link.hpp"

#include <algorithm>
#include <utility>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/chunk_wire.hpp"
#include "bus/port_connection.hpp"
#include "bus/requests.hpp"

namespace voxatlas {
namespace {

/// Data in a chunk that leaves the machine: with its headers it fits an Ethernet packet.
constexpr std::size_t kNetworkChunkBytes = 1300;
/// Of the payloads of one pump(), so that acknowledgements are looked at between.
constexpr std::size_t kChunksAtOnce = 16;

/// Taken before acknowledgements are looked at, even where the service has not come round to its
/// pump(): a producer that hears of nothing until all that waits is taken runs out of credit, and
/// both ends wait for one another (12: 1400 MB/s, all: 1270). The service still gets all at once,
/// so that what it commits together stays large (a tenth of it: 0.48 in place of 0.77 M rays/s).
constexpr int kChunksBetweenAcks = 12;

/// A larger receive buffer is not filled: what is under way would leave the processor's cache
/// (measured: 52 chunks 1400 MB/s, 128 chunks 650).
constexpr std::size_t kMostUnderWay = std::size_t{3} << 20;

/// A message the bus did not take because its hub is away is as good as lost on the way: what must
/// arrive is sent again.
Status unless_hub_lost(Status sent) {
  if (!sent && sent.error().code == ErrorCode::kUnavailable) return {};
  return sent;
}

}  // namespace

struct OutLink::State {
  State(Bus& b, PortConnection p, const Endpoint& consumer, std::int64_t session,
        const StreamConfig& config)
      : bus(b), port(std::move(p)), channel(consumer.chunk_channel()), producer(session, config) {}

  Bus& bus;
  PortConnection port;
  std::string channel;
  StreamProducer producer;
  Bus::Subscription acks = 0;
  Bytes encoded;  ///< Kept, so that its memory is made once.
};

OutLink::OutLink(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutLink::~OutLink() { state_->bus.unsubscribe(state_->acks); }

Result<std::unique_ptr<OutLink>> OutLink::create(Bus& bus, const Endpoint& consumer,
                                                 const StreamConfig& given) {
  auto url = BusUrl::parse(bus.url());
  if (!url) return pass_on(url);
  auto port = PortConnection::open(bus, consumer);
  if (!port) return pass_on(port);
  auto config = given;
  if (url->leaves_host()) config.chunk_bytes = std::min(config.chunk_bytes, kNetworkChunkBytes);
  const auto session = config.client == 0 ? random_id() : client_session(config.client);
  auto state = std::make_unique<State>(bus, std::move(*port), consumer, session, config);
  auto* producer = &state->producer;
  state->acks = bus.subscribe<ack_t>(
      kAckChannel, [producer](const ack_t& ack) { producer->on_ack(ack, steady_utime()); });
  return std::unique_ptr<OutLink>(new OutLink(std::move(state)));
}

StreamProducer& OutLink::producer() { return state_->producer; }

Status OutLink::pump(std::int64_t now) {
  auto& link = *state_;
  Status status;
  link.producer.poll(now, kChunksAtOnce, [&](const chunk_t& head, ByteView data) {
    encode_chunk(head, data, link.encoded);
    status = unless_hub_lost(link.port.bus().publish_bytes(link.channel, link.encoded));
    return status.has_value();
  });
  return status;
}

struct InLink::State {
  State(Bus& b, PortConnection p, const ConsumerConfig& config)
      : bus(b), port(std::move(p)), consumer(random_id(), config) {}

  Status on_chunk(ByteView bytes);
  Status send_acks(std::int64_t now);

  Bus& bus;
  PortConnection port;
  StreamConsumer consumer;
  Bus::Subscription chunks = 0;
  int since_acks = 0;  ///< Chunks taken.
  Status sent;         ///< What became of acknowledgements between two pump()s.
};

Status InLink::State::on_chunk(ByteView bytes) {
  auto chunk = decode_chunk(bytes);
  if (!chunk) return pass_on(chunk);
  const auto now = steady_utime();
  consumer.on_chunk(chunk->head, chunk->data, now);
  if (++since_acks >= kChunksBetweenAcks && sent) sent = send_acks(now);
  return {};
}

Status InLink::State::send_acks(std::int64_t now) {
  since_acks = 0;
  for (const auto& ack : consumer.poll(now)) {
    if (auto ok = unless_hub_lost(bus.publish(kAckChannel, ack)); !ok) return ok;
  }
  return {};
}

InLink::InLink(std::unique_ptr<State> state) : state_(std::move(state)) {}
InLink::~InLink() { state_->port.bus().unsubscribe(state_->chunks); }

Result<std::unique_ptr<InLink>> InLink::create(Bus& bus, const Endpoint& self,
                                               ConsumerConfig config) {
  auto port = PortConnection::open(bus, self);
  if (!port) return pass_on(port);
  auto buffer = receive_buffer_of(port->bus().url());
  if (!buffer) return pass_on(buffer);
  config.receive_buffer_bytes = std::min(*buffer, kMostUnderWay);
  auto state = std::make_unique<State>(bus, std::move(*port), config);
  state->chunks = state->port.bus().subscribe_bytes(
      self.chunk_channel(), [link = state.get()](ByteView bytes) { return link->on_chunk(bytes); });
  return std::unique_ptr<InLink>(new InLink(std::move(state)));
}

StreamConsumer& InLink::consumer() { return state_->consumer; }
Bus& InLink::port() { return state_->port.bus(); }

Status InLink::pump(std::int64_t now) {
  if (auto sent = std::exchange(state_->sent, {}); !sent) return sent;
  return state_->send_acks(now);
}

}  // namespace voxatlas
