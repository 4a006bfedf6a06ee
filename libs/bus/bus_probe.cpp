#include <fmt/format.h>
#include <poll.h>

#include <algorithm>

#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/bus_url.hpp"
#include "bus/requests.hpp"

namespace voxatlas {
namespace {

constexpr const char* kProbeChannel = "VOXATLAS_PROBE";
constexpr std::int64_t kProbeUs = 2'000'000;
constexpr std::int64_t kProbeAgainUs = 500'000;

/// A datagram as large as any, told from another prober's by its random start.
Bytes probe_message() {
  Bytes bytes;
  ByteWriter(bytes).put(random_id());
  bytes.resize(Bus::kMaxPlainBytes);
  return bytes;
}

}  // namespace

Result<void> probe_bus(const std::string& url) {
  auto bus = Bus::create(url);
  if (!bus) return pass_on(bus);
  const auto message = probe_message();
  bool echoed = false;
  (*bus)->subscribe_bytes(kProbeChannel, [&](ByteView bytes) -> Status {
    echoed = echoed || std::ranges::equal(bytes, message);
    return {};
  });
  const auto start = steady_utime();
  std::int64_t next_send = start;
  for (auto now = start; now - start < kProbeUs; now = steady_utime()) {
    if (now >= next_send) {
      if (auto sent = (*bus)->publish_bytes(kProbeChannel, message); !sent) return sent;
      next_send = now + kProbeAgainUs;
    }
    pollfd ready{(*bus)->fd(), POLLIN, 0};
    ::poll(&ready, 1, 50);
    if (auto handled = (*bus)->handle_waiting(); !handled) return handled;
    if (echoed) return {};
  }
  return fail(ErrorCode::kUnavailable,
              fmt::format("{}: {} bytes sent do not come back within 2 s; is a firewall between?",
                          (*bus)->url(), message.size()));
}

}  // namespace voxatlas
