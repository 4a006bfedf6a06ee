#include "bus/service_loop.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "base/notify.hpp"
#include "base/utime.hpp"
#include "bus/channels.hpp"
#include "bus/requests.hpp"
#include "bus/socket_drops.hpp"

namespace voxatlas {
namespace {

constexpr std::int64_t kLongestWaitUs = 500'000;
constexpr std::int64_t kStatusEveryUs = 500'000;

/// The one piece of global state: what a signal handler may touch.
volatile std::sig_atomic_t stop_flag = 0;
volatile std::sig_atomic_t stop_fd = -1;  ///< An eventfd that wakes poll().

void on_stop_signal(int) {
  const int saved = errno;
  stop_flag = 1;
  const std::uint64_t one = 1;
  if (stop_fd >= 0 && ::write(stop_fd, &one, sizeof one) < 0) {  // Full: it is readable already.
  }
  errno = saved;
}

void wait(const ServiceLoop& loop, std::int64_t wait_us) {
  std::vector<pollfd> fds;
  for (const auto* bus : loop.buses) fds.push_back({bus->fd(), POLLIN, 0});
  for (const int fd : loop.wake_fds) fds.push_back({fd, POLLIN, 0});
  fds.push_back({stop_fd, POLLIN, 0});  // poll() passes over a negative descriptor.
  const timespec time{wait_us / 1'000'000, wait_us % 1'000'000 * 1000};
  ::ppoll(fds.data(), fds.size(), &time, nullptr);
}

}  // namespace

const char* voxatlas_version() { return VOXATLAS_VERSION; }

void stop_on_signals() {
  if (stop_fd < 0) stop_fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

bool stop_requested() { return stop_flag != 0; }

Status ServiceLoop::run() {
  while (!stop_requested()) {
    for (auto* bus : buses) {
      if (auto handled = bus->handle_waiting(); !handled) return handled;
    }
    const auto again = work(steady_utime());
    if (!again) return fail(again.error().code, again.error().message);
    if (finished && finished()) return {};
    const auto left = std::clamp<std::int64_t>(*again - steady_utime(), 0, kLongestWaitUs);
    wait(*this, left);
  }
  return {};
}

StatusPublisher::StatusPublisher(Bus& bus, std::string service, std::int32_t index)
    : StatusPublisher(
          [&bus](const status_t& status) { return bus.publish(kStatusChannel, status); },
          std::move(service), index) {
  bus_ = &bus;
}

StatusPublisher::StatusPublisher(Send send, std::string service, std::int32_t index)
    : send_(std::move(send)) {
  status_.utime = 0;
  status_.service = std::move(service);
  status_.index = index;
  status_.instance = random_id();
  status_.pid = ::getpid();
  status_.version = voxatlas_version();
  status_.ready = 0;
  status_.state = "starting";
  status_.counters_count = 0;
}

void StatusPublisher::set_state(bool ready, std::string state) {
  const auto flag = static_cast<std::int8_t>(ready ? 1 : 0);
  if (status_.ready == flag && status_.state == state) return;
  status_.ready = flag;
  status_.state = std::move(state);
  changed_ = true;
}

std::int64_t StatusPublisher::next_pump() const {
  return changed_ ? 0 : last_sent_ + kStatusEveryUs;
}

Status StatusPublisher::pump(std::int64_t now, const std::function<StatusCounters()>& counters) {
  if (now < next_pump()) return {};
  changed_ = false;
  last_sent_ = now;
  status_.utime = utime_now();
  status_.counters.clear();
  auto numbers = counters();
  numbers.emplace_back("kernel_drops", static_cast<double>(socket_drops()));
  if (bus_ != nullptr) {
    numbers.emplace_back("undecodable", static_cast<double>(bus_->counters().undecodable));
  }
  for (auto& [name, value] : numbers) {
    counter_t counter;
    counter.name = std::move(name);
    counter.value = value;
    status_.counters.push_back(std::move(counter));
  }
  status_.counters_count = static_cast<std::int32_t>(status_.counters.size());
  // The same words to systemd: a loop that no longer comes by here is one that its watchdog ends.
  notify_supervisor("READY=1\nWATCHDOG=1\nSTATUS=" + status_.state);
  auto sent = send_(status_);
  // While the hub is away nobody could read it; the next one says the same.
  if (!sent && sent.error().code == ErrorCode::kUnavailable) return {};
  return sent;
}

}  // namespace voxatlas
