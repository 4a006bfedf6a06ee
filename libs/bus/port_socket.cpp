#include "bus/port_socket.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "bus/bus_url.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kMostDatagram = 65'536;
constexpr std::array<std::uint8_t, 4> kShortMagic{'L', 'C', '0', '2'};
constexpr std::size_t kHeadBytes = kShortMagic.size() + 4;
constexpr std::size_t kLongestChannel = 63;

template <class T>
bool set(int fd, int level, int name, const T& value) {
  return ::setsockopt(fd, level, name, &value, sizeof value) == 0;
}

bool join(int fd, const BusUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(url.port));
  if (::inet_pton(AF_INET, url.host.c_str(), &address.sin_addr) != 1) return false;
  const ip_mreq group{address.sin_addr, {htonl(INADDR_ANY)}};
  return set(fd, SOL_SOCKET, SO_REUSEADDR, 1) &&
         ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
         set(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, group);
}

/// As LCM reads the option; more than the machine grants is cut by the kernel.
void ask_for_buffer(int fd, const BusUrl& url) {
  const auto* wanted = url.option("recv_buf_size");
  if (wanted == nullptr) return;
  int bytes = 0;
  std::from_chars(wanted->data(), wanted->data() + wanted->size(), bytes);
  if (bytes > 0) set(fd, SOL_SOCKET, SO_RCVBUF, bytes);
}

}  // namespace

PortSocket::PortSocket(int fd) : fd_(fd), datagram_(kMostDatagram) {}

PortSocket::PortSocket(PortSocket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), datagram_(std::move(other.datagram_)) {}

PortSocket::~PortSocket() {
  if (fd_ >= 0) ::close(fd_);
}

Result<PortSocket> PortSocket::open(const std::string& text) {
  auto url = BusUrl::parse(text);
  if (!url) return pass_on(url);
  PortSocket socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (socket.fd_ < 0 || !join(socket.fd_, *url)) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("no bus at {}: {}", text, std::strerror(errno)));
  }
  ask_for_buffer(socket.fd_, *url);
  return socket;
}

Result<std::optional<ByteView>> PortSocket::receive() {
  const auto got = ::recv(fd_, datagram_.data(), datagram_.size(), 0);
  if (got >= 0) return ByteView(datagram_).first(static_cast<std::size_t>(got));
  if (errno == EAGAIN || errno == EWOULDBLOCK) return std::nullopt;
  return fail(ErrorCode::kIo, fmt::format("a port cannot be read: {}", std::strerror(errno)));
}

std::optional<ShortMessage> short_message(ByteView datagram) {
  if (datagram.size() < kHeadBytes ||
      !std::ranges::equal(datagram.first(kShortMagic.size()), kShortMagic)) {
    return std::nullopt;
  }
  const auto named = datagram.subspan(kHeadBytes);
  const auto name = named.first(std::min(named.size(), kLongestChannel + 1));
  const auto zero = std::ranges::find(name, std::uint8_t{0});
  if (zero == name.end()) return std::nullopt;
  const auto length = static_cast<std::size_t>(zero - name.begin());
  return ShortMessage{{reinterpret_cast<const char*>(name.data()), length},
                      named.subspan(length + 1)};
}

}  // namespace voxatlas
