#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace voxatlas {

/// The receiving end of one multicast port without LCM's: datagrams come straight out of the
/// kernel, where LCM has a thread copy them into a queue and wake the reader by a pipe.
///
/// Borders: bound to its group: what other groups send to the same port does not come.
/// Errors:  open: kUnavailable where the group cannot be joined, receive: kIo.
/// Memory:  one datagram; what waits does so in the kernel's receive buffer, and is lost beyond it.
/// Threads: one at a time.
class PortSocket {
 public:
  static Result<PortSocket> open(const std::string& url);
  ~PortSocket();
  PortSocket(PortSocket&& other) noexcept;
  PortSocket& operator=(PortSocket&&) = delete;

  int fd() const { return fd_; }
  /// The next datagram, good until the next call; nullopt: none waits.
  Result<std::optional<ByteView>> receive();

 private:
  explicit PortSocket(int fd);

  int fd_;
  Bytes datagram_;
};

/// One message as LCM's publish puts it into a datagram.
struct ShortMessage {
  std::string_view channel;
  ByteView data;
};

/// Looks at the message where it is. Any bytes may be given; nullopt: they are none, or a fragment
/// of one that does not fit a datagram.
///
/// Source: LCM's udpm: "LC02", a number of 32 bits, the channel's name and a zero, the data.
std::optional<ShortMessage> short_message(ByteView datagram);

}  // namespace voxatlas
