#include "bus/socket_drops.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TEST_CASE("the drops of one's own sockets are summed, others' are not", "[bus]") {
  const char* text =
      "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
      "inode ref pointer drops\n"
      "  481: 00000000:1DF3 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 "
      "111 2 0000000000000000 7\n"
      "  481: 00000000:1DF3 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 "
      "222 2 0000000000000000 50\n"
      "  482: 00000000:1DF4 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 "
      "333 2 0000000000000000 4\n";
  CHECK(drops_in(text, {111, 333}) == 11);
  CHECK(drops_in(text, {}) == 0);
  CHECK(drops_in("", {111}) == 0);
  CHECK(drops_in("nonsense\n\n 1 2 3", {111}) == 0);
}

TEST_CASE("what the kernel drops for want of a reader is counted", "[bus]") {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::bind(fd, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0);
  socklen_t size = sizeof where;
  REQUIRE(::getsockname(fd, reinterpret_cast<sockaddr*>(&where), &size) == 0);
  const int least = 1;
  REQUIRE(::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &least, sizeof least) == 0);
  const auto before = socket_drops();
  const char datagram[1000] = {};
  for (int i = 0; i < 100; ++i) {
    ::sendto(fd, datagram, sizeof datagram, 0, reinterpret_cast<const sockaddr*>(&where),
             sizeof where);
  }
  int arrived = 0;
  char buffer[1000];
  while (::recv(fd, buffer, sizeof buffer, MSG_DONTWAIT) > 0) ++arrived;
  CHECK(socket_drops() - before == static_cast<std::uint64_t>(100 - arrived));
  CHECK(arrived < 100);
  ::close(fd);
}

}  // namespace
}  // namespace voxatlas
