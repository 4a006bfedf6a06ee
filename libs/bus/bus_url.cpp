#include "bus/bus_url.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <limits>

#include "bus/endpoint.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kHubClientBytes = std::size_t{8} << 20;  ///< As voxatlas-hub holds a client.
constexpr std::size_t kOwnQueueBytes = std::size_t{64} << 20;  ///< memq: the process's own memory.

Result<std::int32_t> parse_number(const std::string& text, const std::string& url) {
  std::int32_t number = 0;
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stop != end || number < 0) {
    return fail(ErrorCode::kInvalid, fmt::format("bus URL '{}': '{}' is no number", url, text));
  }
  return number;
}

Result<std::vector<std::pair<std::string, std::string>>> parse_options(const std::string& text,
                                                                       const std::string& url) {
  std::vector<std::pair<std::string, std::string>> options;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('&', at), text.size());
    const auto equals = text.find('=', at);
    if (equals >= end) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("bus URL '{}': option without '=' in '{}'", url, text));
    }
    options.emplace_back(text.substr(at, equals - at), text.substr(equals + 1, end - equals - 1));
    at = end + 1;
  }
  return options;
}

Status parse_network(const std::string& network, const std::string& url, BusUrl& parsed) {
  const auto colon = network.find(':');
  parsed.host = network.substr(0, colon);
  if (colon == std::string::npos) return {};
  auto port = parse_number(network.substr(colon + 1), url);
  if (!port) return pass_on(port);
  if (*port < 1 || *port > 65'535) {
    return fail(ErrorCode::kInvalid, fmt::format("bus URL '{}': port {} is none", url, *port));
  }
  parsed.port = *port;
  return {};
}

/// A UDP socket, to be asked what the kernel grants.
class ProbeSocket {
 public:
  ProbeSocket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~ProbeSocket() {
    if (fd_ >= 0) ::close(fd_);
  }
  ProbeSocket(const ProbeSocket&) = delete;
  ProbeSocket& operator=(const ProbeSocket&) = delete;

  bool ok() const { return fd_ >= 0; }
  void ask(int bytes) { ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes); }
  int granted() const {
    int bytes = 0;
    socklen_t size = sizeof bytes;
    ::getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &bytes, &size);
    return bytes;
  }

 private:
  int fd_;
};

/// What to ask for in recv_buf_size to be granted the most; the kernel then counts the double.
std::int32_t largest_receive_buffer() {
  ProbeSocket socket;
  if (!socket.ok()) return 0;
  socket.ask(std::numeric_limits<int>::max() / 2);
  return socket.granted() / 2;
}

}  // namespace

Result<BusUrl> BusUrl::parse(const std::string& given) {
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  const std::string url = !given.empty()                                          ? given
                          : from_environment != nullptr && *from_environment != 0 ? from_environment
                                                                                  : kDefaultBusUrl;
  const auto colon = url.find("://");
  if (colon == std::string::npos || colon == 0) {
    return fail(ErrorCode::kInvalid,
                fmt::format("bus URL '{}': wanted is something like {}", url, kDefaultBusUrl));
  }
  BusUrl parsed;
  parsed.provider = url.substr(0, colon);
  const auto question = url.find('?', colon);
  const auto network = url.substr(
      colon + 3, question == std::string::npos ? std::string::npos : question - colon - 3);
  if (question != std::string::npos) {
    auto options = parse_options(url.substr(question + 1), url);
    if (!options) return pass_on(options);
    parsed.options = std::move(*options);
  }
  if (parsed.provider == "memq") return parsed;
  if (auto split = parse_network(network, url, parsed); !split) return pass_on(split);
  if (parsed.host.empty()) parsed.host = parsed.is_multicast() ? "239.255.76.67" : "127.0.0.1";
  if (parsed.port == 0) parsed.port = parsed.is_multicast() ? 7667 : 7700;  // As LCM has it.
  return parsed;
}

BusUrl BusUrl::with_large_buffer() const {
  BusUrl url = *this;
  if (!is_multicast() || option("recv_buf_size") != nullptr) return url;
  if (const auto bytes = largest_receive_buffer(); bytes > 0) {
    url.options.emplace_back("recv_buf_size", std::to_string(bytes));
  }
  return url;
}

std::string BusUrl::to_string() const {
  std::string url = provider + "://";
  if (!host.empty()) url += fmt::format("{}:{}", host, port);
  char separator = '?';
  for (const auto& [key, value] : options) {
    url += fmt::format("{}{}={}", separator, key, value);
    separator = '&';
  }
  return url;
}

const std::string* BusUrl::option(const std::string& wanted) const {
  for (const auto& [key, value] : options) {
    if (key == wanted) return &value;
  }
  return nullptr;
}

bool BusUrl::leaves_host() const {
  const auto* ttl = option("ttl");
  return is_multicast() && ttl != nullptr && *ttl != "0";
}

Result<std::size_t> receive_buffer_of(const std::string& text) {
  auto url = BusUrl::parse(text);
  if (!url) return pass_on(url);
  if (url->provider == "memq") return kOwnQueueBytes;
  if (!url->is_multicast()) return kHubClientBytes;
  ProbeSocket socket;
  if (!socket.ok()) return fail(ErrorCode::kIo, "no UDP socket to measure a receive buffer on");
  if (const auto* wanted = url->option("recv_buf_size")) {
    auto bytes = parse_number(*wanted, text);
    if (!bytes) return pass_on(bytes);
    socket.ask(*bytes);
  }
  return static_cast<std::size_t>(socket.granted());
}

Result<std::string> url_at_port(const std::string& text, std::int32_t offset) {
  auto url = BusUrl::parse(text);
  if (!url) return pass_on(url);
  if (!url->is_multicast() || offset == 0) return url->to_string();
  if (url->port + offset > 65'535) {
    return fail(ErrorCode::kInvalid,
                fmt::format("bus URL '{}': port {} + {} is none", text, url->port, offset));
  }
  url->port += offset;
  return url->with_large_buffer().to_string();
}

}  // namespace voxatlas
