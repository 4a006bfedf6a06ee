#include "base/notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace voxatlas {
namespace {

/// What systemd holds: a socket by the name given. '@' stands for the zero byte of an abstract
/// name.
class Supervisor {
 public:
  explicit Supervisor(std::string name) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name.front() == '@') address.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(sizeof address.sun_family + name.size());
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), length) == 0);
    ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Supervisor() {
    ::close(fd_);
    ::unsetenv("NOTIFY_SOCKET");
  }

  /// The next datagram, or "nothing".
  std::string heard() const {
    std::array<char, 256> words{};
    const auto size = ::recv(fd_, words.data(), words.size(), 0);
    return size < 0 ? "nothing" : std::string(words.data(), static_cast<std::size_t>(size));
  }

 private:
  int fd_;
};

std::string own_name(std::string_view before) {
  return std::string(before) + "voxatlas-notify-test-" + std::to_string(::getpid());
}

TEST_CASE("a supervisor hears the words as one datagram, by either kind of name", "[base]") {
  const auto name = own_name(GENERATE("/tmp/", "@"));
  {
    const Supervisor supervisor(name);
    notify_supervisor("READY=1\nSTATUS=waiting for tilestore 0");
    REQUIRE(supervisor.heard() == "READY=1\nSTATUS=waiting for tilestore 0");
    REQUIRE(supervisor.heard() == "nothing");
  }
  if (name.front() == '/') ::unlink(name.c_str());
}

TEST_CASE("a supervisor that never reads does not hold up a service", "[base]") {
  const Supervisor supervisor(own_name("@deaf-"));
  for (int i = 0; i < 10'000; ++i) notify_supervisor("WATCHDOG=1");  // Far more than a queue holds.
  REQUIRE(supervisor.heard() == "WATCHDOG=1");
}

TEST_CASE("without a supervisor, or with a name too long for a socket, nothing happens", "[base]") {
  ::unsetenv("NOTIFY_SOCKET");
  notify_supervisor("READY=1");
  ::setenv("NOTIFY_SOCKET", std::string(500, 'x').c_str(), 1);
  notify_supervisor("READY=1");
  ::unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace voxatlas
