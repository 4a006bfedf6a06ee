#include "hub/hub_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <vector>

#include "base/log.hpp"
#include "base/utime.hpp"

namespace voxatlas {
namespace {

constexpr std::size_t kReadBytes = std::size_t{256} << 10;
constexpr std::size_t kPieces = 64;  ///< Sent in one call.
constexpr int kSendBuffer = 4 << 20;
constexpr std::int64_t kLogEveryUs = 1'000'000;

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int fd() const { return fd_; }

 private:
  int fd_;
};

void set(int fd, int level, int option, int value) {
  ::setsockopt(fd, level, option, &value, sizeof value);
}

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

std::string reason() { return std::strerror(errno); }

}  // namespace

struct HubServer::State {
  State(Socket s, const HubConfig& config)
      : socket(std::move(s)), service(config), buffer(kReadBytes) {}

  void accept();
  bool read(HubService::ClientId client, int fd);   ///< False: close it.
  bool write(HubService::ClientId client, int fd);  ///< False: close it.
  void log_dropped();

  Socket socket;
  HubService service;
  std::map<HubService::ClientId, Socket> clients;
  Bytes buffer;
  std::uint64_t dropped_told = 0;
  std::int64_t last_log = 0;
};

HubServer::HubServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HubServer::~HubServer() = default;

Result<std::unique_ptr<HubServer>> HubServer::listen(const std::string& address, std::int32_t port,
                                                     const HubConfig& config) {
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(static_cast<std::uint16_t>(port));
  if (port < 0 || port > 65'535 || ::inet_pton(AF_INET, address.c_str(), &where.sin_addr) != 1) {
    return fail(ErrorCode::kInvalid, fmt::format("hub address {}:{}: an IPv4 address in digits "
                                                 "and a port are wanted",
                                                 address, port));
  }
  Socket socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  set(socket.fd(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (socket.fd() < 0 ||
      ::bind(socket.fd(), reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0 ||
      ::listen(socket.fd(), SOMAXCONN) != 0) {
    return fail(ErrorCode::kIo, fmt::format("hub address {}:{}: {}", address, port, reason()));
  }
  auto state = std::make_unique<State>(std::move(socket), config);
  return std::unique_ptr<HubServer>(new HubServer(std::move(state)));
}

std::int32_t HubServer::port() const {
  sockaddr_in where{};
  socklen_t size = sizeof where;
  ::getsockname(state_->socket.fd(), reinterpret_cast<sockaddr*>(&where), &size);
  return ntohs(where.sin_port);
}

HubService& HubServer::service() { return state_->service; }

void HubServer::State::accept() {
  while (true) {
    Socket accepted(::accept4(socket.fd(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (accepted.fd() < 0) return;
    auto client = service.connect();
    if (!client) {
      log_warning("client refused: {}", client.error().message);
      continue;
    }
    set(accepted.fd(), IPPROTO_TCP, TCP_NODELAY, 1);
    set(accepted.fd(), SOL_SOCKET, SO_SNDBUF, kSendBuffer);
    clients.emplace(*client, std::move(accepted));
  }
}

bool HubServer::State::read(HubService::ClientId client, int fd) {
  const auto count = ::recv(fd, buffer.data(), buffer.size(), 0);
  if (count < 0) return would_block();
  if (count == 0) return false;
  const auto received = service.receive(client, {buffer.data(), static_cast<std::size_t>(count)});
  if (!received) log_warning("client {} closed: {}", client, received.error().message);
  return received.has_value();
}

bool HubServer::State::write(HubService::ClientId client, int fd) {
  while (service.has_waiting(client)) {
    std::vector<iovec> pieces;
    for (const auto piece : service.waiting(client, kPieces)) {
      pieces.push_back({const_cast<std::uint8_t*>(piece.data()), piece.size()});
    }
    msghdr message{};
    message.msg_iov = pieces.data();
    message.msg_iovlen = pieces.size();
    const auto count = ::sendmsg(fd, &message, MSG_NOSIGNAL);
    if (count < 0) return would_block();
    service.sent(client, static_cast<std::size_t>(count));
  }
  return true;
}

void HubServer::State::log_dropped() {
  const auto dropped = service.counters().dropped;
  const auto now = steady_utime();
  if (dropped == dropped_told || now - last_log < kLogEveryUs) return;
  log_warning("{} messages dropped for clients that do not read", dropped - dropped_told);
  dropped_told = dropped;
  last_log = now;
}

Status HubServer::serve(int wait_ms) {
  auto& state = *state_;
  std::vector<pollfd> fds{{state.socket.fd(), POLLIN, 0}};
  std::vector<HubService::ClientId> ids;
  for (const auto& [id, socket] : state.clients) {
    const short events = state.service.has_waiting(id) ? POLLIN | POLLOUT : POLLIN;
    fds.push_back({socket.fd(), events, 0});
    ids.push_back(id);
  }
  if (::poll(fds.data(), fds.size(), wait_ms) < 0) {
    if (errno == EINTR) return {};
    return fail(ErrorCode::kIo, fmt::format("hub: poll: {}", reason()));
  }
  std::vector<HubService::ClientId> closing;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (fds[i + 1].revents != 0 && (fds[i + 1].revents & POLLOUT) != fds[i + 1].revents &&
        !state.read(ids[i], fds[i + 1].fd)) {
      closing.push_back(ids[i]);
    }
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!state.write(ids[i], fds[i + 1].fd)) closing.push_back(ids[i]);
  }
  for (const auto id : closing) {
    state.clients.erase(id);
    state.service.disconnect(id);
  }
  if (fds[0].revents != 0) state.accept();
  state.log_dropped();
  return {};
}

}  // namespace voxatlas
