#include "bus/requests.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>

#include "base/check.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/port_connection.hpp"

namespace voxatlas {

std::int64_t random_id() {
  std::uint64_t bits = 0;
  while (bits == 0) {
    VOX_CHECK(::getrandom(&bits, sizeof bits, 0) == static_cast<ssize_t>(sizeof bits));
    bits >>= 1;
  }
  return static_cast<std::int64_t>(bits);
}

struct ReplyPorts::State {
  struct Open {
    PortConnection connection;
    std::uint64_t used;  ///< The later, the higher.
  };

  static constexpr std::size_t kMostPorts = 64;

  Bus& bus;
  std::map<std::int32_t, Open> open;  ///< By port offset.
  std::uint64_t uses = 0;
};

ReplyPorts::ReplyPorts(Bus& bus) : state_(new State{bus, {}, 0}) {}
ReplyPorts::~ReplyPorts() = default;

Result<Bus*> ReplyPorts::at(std::int32_t reply_port) {
  auto& state = *state_;
  if (reply_port == 0) return &state.bus;
  auto endpoint = Endpoint::client_at(reply_port);
  if (!endpoint) return pass_on(endpoint);
  ++state.uses;
  const auto known = state.open.find(reply_port);
  if (known != state.open.end()) {
    known->second.used = state.uses;
    return &known->second.connection.bus();
  }
  auto connection = PortConnection::open(state.bus, *endpoint);
  if (!connection) return pass_on(connection);
  if (state.open.size() >= State::kMostPorts) {
    state.open.erase(std::ranges::min_element(state.open, {},
                                              [](const auto& entry) { return entry.second.used; }));
  }
  const auto [it, added] =
      state.open.emplace(reply_port, State::Open{std::move(*connection), state.uses});
  return &it->second.connection.bus();
}

}  // namespace voxatlas
