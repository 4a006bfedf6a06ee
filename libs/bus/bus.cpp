#include "bus/bus.hpp"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <exception>
#include <map>
#include <string_view>
#include <vector>

#include "base/check.hpp"
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/port_socket.hpp"

namespace voxatlas {
namespace {

constexpr int kMaxBatch = 4000;
constexpr std::int64_t kReconnectUs = 500'000;
constexpr std::int64_t kLogEveryUs = 1'000'000;
/// Nobody listens here: a message on it makes LCM connect to its hub again.
constexpr const char* kReconnectChannel = "VOXATLAS_RECONNECT";
constexpr const char* kAddRoute =
    "; without a multicast route, add one: ip link set lo up; ip route add 224.0.0.0/4 dev lo";

/// LCM reads a channel to subscribe to as a regular expression; ours are names.
std::string as_pattern(std::string_view channel) {
  std::string pattern;
  for (const char c : channel) {
    if (std::string_view("\\^$.|?*+()[]{}").find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

struct Handler {
  Bus::Subscription id;
  std::function<Status(ByteView)> call;
  bool alive = true;
};

}  // namespace

struct Bus::State {
  struct Channel {
    State* bus;
    lcm_subscription_t* subscription;
    std::vector<std::unique_ptr<Handler>> handlers;
  };

  ~State() {
    if (lcm != nullptr) lcm_destroy(lcm);
  }

  static void on_message(const lcm_recv_buf_t* received, const char* name, void* channel) noexcept;
  void dispatch(Channel& channel, const char* name, ByteView bytes) noexcept;
  void log_undecodable(const char* name, const Error& error);
  void purge();
  Status listen(const std::string& name, Channel& channel);
  Result<bool> handle_datagram();
  Result<bool> handle_in_lcm();
  void notice_connection();
  void reconnect();

  std::string url;
  bool is_hub = false;
  bool is_multicast = false;
  bool is_port = false;
  std::optional<PortSocket> socket;  ///< Of a port, from the first subscription on.
  int hub_fd = -1;                   ///< The connection to a hub that is set up; -1: none.
  bool was_lost = false;             ///< And there was one before.
  lcm_t* lcm = nullptr;
  std::map<std::string, std::unique_ptr<Channel>, std::less<>> channels;
  std::map<Subscription, std::string> channel_of;
  Subscription last_subscription = 0;
  Counters counters;
  bool in_handler = false;
  bool has_dead_handlers = false;
  std::exception_ptr thrown;  ///< By a handler; rethrown outside of LCM.
  Status listening;           ///< Whether all channels could be subscribed to.
  std::int64_t last_reconnect = 0;
  std::int64_t last_log = 0;
};

void Bus::State::on_message(const lcm_recv_buf_t* received, const char* name,
                            void* opaque) noexcept {
  auto& channel = *static_cast<Channel*>(opaque);
  channel.bus->dispatch(channel, name,
                        {static_cast<const std::uint8_t*>(received->data), received->data_size});
}

void Bus::State::dispatch(Channel& channel, const char* name, ByteView bytes) noexcept try {
  ++counters.received;
  counters.received_bytes += bytes.size();
  bool decoded = true;
  const auto count = channel.handlers.size();  // Those that a handler adds wait for the next.
  for (std::size_t i = 0; i < count; ++i) {
    auto& handler = *channel.handlers[i];
    if (!handler.alive) continue;
    if (auto status = handler.call(bytes); !status && decoded) {
      decoded = false;
      ++counters.undecodable;
      log_undecodable(name, status.error());
    }
  }
} catch (...) {  // LCM is C: the exception goes round it.
  thrown = std::current_exception();
}

void Bus::State::log_undecodable(const char* name, const Error& error) {
  const auto now = steady_utime();
  if (last_log != 0 && now - last_log < kLogEveryUs) return;
  last_log = now;
  log_warning("{}: message dropped: {} ({} so far)", name, error.message, counters.undecodable);
}

void Bus::State::purge() {
  if (!has_dead_handlers) return;
  has_dead_handlers = false;
  for (auto it = channels.begin(); it != channels.end();) {
    std::erase_if(it->second->handlers, [](const auto& handler) { return !handler->alive; });
    if (!it->second->handlers.empty()) {
      ++it;
      continue;
    }
    if (it->second->subscription != nullptr) lcm_unsubscribe(lcm, it->second->subscription);
    it = channels.erase(it);
  }
}

Status Bus::State::listen(const std::string& name, Channel& channel) {
  if (socket) return {};
  if (is_port) {
    auto opened = PortSocket::open(url);
    if (!opened) return pass_on(opened);
    socket.emplace(std::move(*opened));
    return {};
  }
  channel.subscription = lcm_subscribe(lcm, as_pattern(name).c_str(), &on_message, &channel);
  notice_connection();
  if (channel.subscription == nullptr) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("no bus at {}: subscribing to {} failed", url, name));
  }
  lcm_subscription_set_queue_capacity(channel.subscription, kQueuedMessages);
  return {};
}

/// False: none waited.
Result<bool> Bus::State::handle_datagram() {
  auto datagram = socket->receive();
  if (!datagram) return pass_on(datagram);
  if (!*datagram) return false;
  const auto message = short_message(**datagram);
  const auto known = message ? channels.find(message->channel) : channels.end();
  if (known != channels.end()) dispatch(*known->second, known->first.c_str(), message->data);
  return true;
}

Result<bool> Bus::State::handle_in_lcm() {
  pollfd ready{lcm_get_fileno(lcm), POLLIN, 0};
  if (ready.fd < 0 || ::poll(&ready, 1, 0) <= 0) return false;
  if (lcm_handle(lcm) >= 0) return true;
  if (!is_hub) return fail(ErrorCode::kIo, fmt::format("{}: LCM cannot read", url));
  notice_connection();
  return true;
}

/// After any call that may have found a hub or lost it. Without NODELAY, small messages would wait
/// 40 ms for an acknowledgement of TCP's.
void Bus::State::notice_connection() {
  const int fd = is_hub ? lcm_get_fileno(lcm) : -1;
  if (fd == hub_fd) return;
  if (hub_fd >= 0) log_warning("the hub at {} is gone", url);
  if (hub_fd < 0 && was_lost) log_info("the hub at {} is back", url);
  was_lost = fd < 0;
  hub_fd = fd;
  const int on = 1;
  if (fd >= 0) ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

void Bus::State::reconnect() {
  const auto now = steady_utime();
  if (last_reconnect != 0 && now - last_reconnect < kReconnectUs) return;
  last_reconnect = now;
  lcm_publish(lcm, kReconnectChannel, "", 0);
  notice_connection();
}

Bus::Bus(std::unique_ptr<State> state) : state_(std::move(state)) {}
Bus::~Bus() = default;

Result<std::unique_ptr<Bus>> Bus::create(const std::string& text) {
  auto url = BusUrl::parse(text);
  if (!url) return pass_on(url);
  auto state = std::make_unique<State>();
  state->url = url->to_string();
  state->is_hub = url->provider == "tcpq";
  state->is_multicast = url->is_multicast();
  state->lcm = lcm_create(url->with_large_buffer().to_string().c_str());
  if (state->lcm == nullptr) {
    return fail(ErrorCode::kUnavailable, fmt::format("no bus at {}: LCM refuses it{}", state->url,
                                                     state->is_multicast ? kAddRoute : ""));
  }
  if (state->is_hub) {
    if (lcm_get_fileno(state->lcm) < 0) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("no hub at {}: voxatlas-hub is not running there", state->url));
    }
    state->notice_connection();
  }
  return std::unique_ptr<Bus>(new Bus(std::move(state)));
}

Result<std::unique_ptr<Bus>> Bus::create_port(const std::string& url) {
  auto bus = create(url);
  if (bus) (*bus)->state_->is_port = (*bus)->state_->is_multicast;
  return bus;
}

Status Bus::publish_bytes(const std::string& channel, const Bytes& bytes) {
  auto& bus = *state_;
  const auto limit = channel == kFrameChannel ? kMaxFrameBytes : kMaxPlainBytes;
  if (bytes.size() > limit) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes, at most {} arrive", channel, bytes.size(), limit));
  }
  if (bus.is_hub && lcm_get_fileno(bus.lcm) < 0) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: the hub at {} is gone", channel, bus.url));
  }
  if (lcm_publish(bus.lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) !=
      0) {
    bus.notice_connection();
    return fail(
        bus.is_hub ? ErrorCode::kUnavailable : ErrorCode::kIo,
        fmt::format("{}: LCM could not send {} bytes to {}", channel, bytes.size(), bus.url));
  }
  ++bus.counters.published;
  bus.counters.published_bytes += bytes.size();
  return {};
}

Bus::Subscription Bus::subscribe_bytes(const std::string& name,
                                       std::function<Status(ByteView)> handler) {
  auto& bus = *state_;
  auto& channel = bus.channels[name];
  if (channel == nullptr) {
    channel = std::make_unique<State::Channel>(State::Channel{&bus, nullptr, {}});
    if (bus.listening) bus.listening = bus.listen(name, *channel);
  }
  const auto id = ++bus.last_subscription;
  channel->handlers.push_back(std::make_unique<Handler>(Handler{id, std::move(handler)}));
  bus.channel_of.emplace(id, name);
  return id;
}

void Bus::unsubscribe(Subscription subscription) {
  auto& bus = *state_;
  const auto known = bus.channel_of.find(subscription);
  if (known == bus.channel_of.end()) return;
  for (const auto& handler : bus.channels.at(known->second)->handlers) {
    if (handler->id == subscription) handler->alive = false;
  }
  bus.channel_of.erase(known);
  bus.has_dead_handlers = true;
  if (!bus.in_handler) bus.purge();
}

int Bus::fd() const { return state_->socket ? state_->socket->fd() : lcm_get_fileno(state_->lcm); }

Status Bus::handle_waiting() {
  auto& bus = *state_;
  VOX_CHECK(!bus.in_handler);
  if (!bus.listening) return bus.listening;
  if (bus.is_hub && fd() < 0) bus.reconnect();
  for (int i = 0; i < kMaxBatch; ++i) {
    bus.in_handler = true;
    auto handled = bus.socket ? bus.handle_datagram() : bus.handle_in_lcm();
    bus.in_handler = false;
    bus.purge();
    if (bus.thrown) std::rethrow_exception(std::exchange(bus.thrown, nullptr));
    if (!handled) return pass_on(handled);
    if (!*handled) break;
  }
  return {};
}

const std::string& Bus::url() const { return state_->url; }
bool Bus::has_ports() const { return state_->is_multicast; }
const Bus::Counters& Bus::counters() const { return state_->counters; }

}  // namespace voxatlas
