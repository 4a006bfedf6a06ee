#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/service_loop.hpp"
#include "cli/watch.hpp"

namespace voxatlas {

/// When the time a person gave is over; INT64_MAX: never. Steady microseconds.
inline std::int64_t watch_deadline(const WatchOptions& options) {
  if (options.timeout <= 0) return INT64_MAX;
  return steady_utime() + static_cast<std::int64_t>(options.timeout * 1e6);
}

/// Subscribes, then prints until a signal, `done`, or the time is over, which is an error. `tick`
/// is called after whatever came and when it says, in steady microseconds.
template <class Message>
Status watch_channel(const WatchOptions& options, const char* channel,
                     const std::function<Status(const Message&)>& print,
                     const std::function<bool()>& done,
                     const std::function<std::int64_t(std::int64_t)>& tick = {}) {
  auto bus = Bus::create(options.url);
  if (!bus) return pass_on(bus);
  Status printed;
  (*bus)->subscribe<Message>(channel, [&](const Message& message) {
    if (printed && !done()) printed = print(message);
  });
  const std::int64_t deadline = watch_deadline(options);
  ServiceLoop loop;
  loop.buses = {bus->get()};
  loop.finished = done;
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    const auto again = tick ? std::min(tick(now), deadline) : deadline;
    std::fflush(stdout);
    if (!printed) return pass_on(printed);
    if (now >= deadline && !done()) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("nothing more came on {} within {} s", channel, options.timeout));
    }
    return again;
  };
  return loop.run();
}

}  // namespace voxatlas
