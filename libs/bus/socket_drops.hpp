#pragma once

#include <cstdint>
#include <set>
#include <string_view>

namespace voxatlas {

/// Datagrams that the kernel has dropped because this process's sockets were full: what LCM loses
/// and never tells. Of the sockets open now, each since it was opened; 0 where /proc is not there.
/// Cost: reads /proc/self/fd and /proc/net/udp: tens of microseconds; for a status, not for a loop.
std::uint64_t socket_drops();

/// The sum of the last column of /proc/net/udp's text over the sockets with these inodes.
std::uint64_t drops_in(std::string_view proc_net_udp, const std::set<std::uint64_t>& inodes);

}  // namespace voxatlas
