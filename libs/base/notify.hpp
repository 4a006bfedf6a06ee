#pragma once

#include <string>

namespace voxatlas {

/// Tells systemd, where it has started this process, how it is: the words of sd_notify(3), such as
/// "READY=1\nWATCHDOG=1\nSTATUS=replaying the journal", in one datagram to $NOTIFY_SOCKET.
///
/// Does nothing where NOTIFY_SOCKET is not set. Never waits, and tells no errors: a service goes on
/// where its supervisor does not listen; the watchdog is the supervisor's way to see that.
/// Threads: one at a time.
void notify_supervisor(const std::string& words);

}  // namespace voxatlas
