#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace voxatlas {

/// The bus where nobody says otherwise: multicast that does not leave this machine.
inline constexpr const char* kDefaultBusUrl = "udpm://239.255.76.67:7667?ttl=0";

/// An LCM URL in its parts: provider://host:port?key=value&key=value.
struct BusUrl {
  std::string provider;
  std::string host;
  std::int32_t port = 0;
  std::vector<std::pair<std::string, std::string>> options;

  /// An empty URL means LCM_DEFAULT_URL, else kDefaultBusUrl.
  /// Errors: kInvalid for what is none, naming it.
  static Result<BusUrl> parse(const std::string& url);

  std::string to_string() const;
  const std::string* option(const std::string& key) const;  ///< nullptr where it is not given.

  /// The same, asking for the largest receive buffer the kernel grants where nothing else is said:
  /// a scan that a logger sends in one burst is more than the usual 208 kB.
  BusUrl with_large_buffer() const;

  bool is_multicast() const { return provider == "udpm"; }
  /// Whether messages may leave the machine (a TTL of 1 or more): they must then fit a real
  /// network's packets.
  bool leaves_host() const;
};

/// How many bytes the kernel holds for a subscriber of `url` that does not read; beyond, multicast
/// loses. For the hub, what it holds per client. Measured on a socket, not read from settings that
/// a container may not show. Errors: kInvalid for a URL that cannot be read, kIo without sockets.
Result<std::size_t> receive_buffer_of(const std::string& url);

/// Tries the bus for real: connects, subscribes and sends itself 60 kB, which must come back within
/// two seconds. Errors: kUnavailable, saying what is missing and, where a command adds it, which.
Result<void> probe_bus(const std::string& url);

}  // namespace voxatlas
