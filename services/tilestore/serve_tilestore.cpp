// The process's lives: after an error of the disk it begins a new one.
#include "base/log.hpp"
#include "base/utime.hpp"
#include "bus/service_loop.hpp"
#include "tilestore/tilestore_process.hpp"

namespace voxatlas {

/// For a second, or until a signal: on the bus, but not at work.
static Status say_disk_fails(const TilestoreOptions& options, const std::string& why) {
  constexpr std::int64_t kRetryEvery = 1'000'000;
  const auto until = steady_utime() + kRetryEvery;
  auto bus = Bus::create(options.url);
  if (!bus) return pass_on(bus);
  StatusPublisher status(**bus, "tilestore", options.shard);
  status.set_state(false, "the disk fails: " + why);
  ServiceLoop loop;
  loop.buses = {bus->get()};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    if (auto sent = status.pump(now, [] { return StatusCounters(); }); !sent) {
      return pass_on(sent);
    }
    return until;
  };
  loop.finished = [until] { return steady_utime() >= until; };
  return loop.run();
}

/// After a failed write nobody knows what the disk holds: only opening anew, as after a kill,
/// tells.
Status serve_tilestore(const TilestoreOptions& options) {
  for (bool was_ready = false;;) {
    auto ended = serve_until_fault(options, was_ready);
    if (ended || !was_ready || stop_requested()) return ended;
    const auto code = ended.error().code;
    if (code != ErrorCode::kIo && code != ErrorCode::kUnknown) return ended;
    log_error("the disk fails, the store is opened again every second: {}", ended.error().message);
    if (auto said = say_disk_fails(options, ended.error().message); !said) return said;
    if (stop_requested()) return ended;
  }
}

}  // namespace voxatlas
