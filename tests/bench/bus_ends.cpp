#include "bus_ends.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <utility>
#include <vector>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/service_loop.hpp"
#include "bus/stream_link.hpp"

namespace voxatlas::bench {
namespace {

const Endpoint kConsumer{EndpointClass::kStore, 99};
constexpr const char* kRawChannel = "VOXATLAS_BENCH_RAW";
constexpr std::size_t kMostHeld = std::size_t{16} << 20;

double cpu_seconds(const rusage& usage) {
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double own_cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return cpu_seconds(usage);
}

double resident_MB() {
  std::size_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

Usage reap(pid_t pid, bool may_fail) {
  rusage usage{};
  int status = 0;
  if (::wait4(pid, &status, 0, &usage) != pid) give_up("a child is gone");
  if (status != 0 && !may_fail) give_up("a child failed");
  return {cpu_seconds(usage), static_cast<double>(usage.ru_maxrss) * 1024 / 1e6};
}

}  // namespace

void give_up(const std::string& what) {
  fmt::print(stderr, "bench_bus: {}\n", what);
  std::exit(1);
}

Usage end_child(pid_t pid) {
  ::kill(pid, SIGKILL);
  return reap(pid, true);
}

Usage wait_for_child(pid_t pid) { return reap(pid, false); }

Sent produce(const std::string& url, const Load& load) {
  auto bus = must(Bus::create(url));
  auto out = must(OutLink::create(*bus, kConsumer, {}));
  // Made before the clock starts: what a message costs to make is its maker's.
  std::vector<Bytes> messages(static_cast<std::size_t>(load.messages),
                              Bytes(load.message_bytes, 0x5a));
  auto& producer = out->producer();
  Sent sent;
  const auto start = steady_utime();
  const auto cpu = own_cpu_seconds();
  ServiceLoop loop;
  loop.buses = {bus.get()};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    while (producer.offered_messages() < load.messages && producer.held_bytes() < kMostHeld) {
      producer.offer(MessageKind::kScan,
                     std::move(messages[static_cast<std::size_t>(producer.offered_messages())]));
    }
    if (auto pumped = out->pump(now); !pumped) return pass_on(pumped);
    if (sent.early_MB == 0 && producer.committed_messages() > load.messages / 4) {
      sent.early_MB = resident_MB();
    }
    return producer.next_poll(steady_utime());
  };
  loop.finished = [&] { return producer.committed_messages() == load.messages; };
  if (auto ended = loop.run(); !ended) give_up(ended.error().message);
  sent.seconds = static_cast<double>(steady_utime() - start) / 1e6;
  sent.cpu_seconds = own_cpu_seconds() - cpu;
  sent.late_MB = resident_MB();
  sent.chunks_sent = producer.counters().chunks_sent;
  sent.chunks_resent = producer.counters().chunks_resent;
  sent.ack_bytes = bus->counters().received_bytes;
  return sent;
}

Sent publish_raw(const std::string& url, const Load& load) {
  auto bus = must(Bus::create(must(url_at_port(url, kConsumer.port_offset()))));
  const Bytes chunk(load.message_bytes, 0x5a);
  Sent sent;
  const auto start = steady_utime();
  const auto cpu = own_cpu_seconds();
  for (std::int64_t i = 0; i < load.messages; ++i) {
    if (auto ok = bus->publish_bytes(kRawChannel, chunk); !ok) give_up(ok.error().message);
  }
  sent.seconds = static_cast<double>(steady_utime() - start) / 1e6;
  sent.cpu_seconds = own_cpu_seconds() - cpu;
  return sent;
}

void count_raw(const std::string& url, RawCount& count) {
  auto bus = must(Bus::create(must(url_at_port(url, kConsumer.port_offset()))));
  bus->subscribe_bytes(kRawChannel, [&](ByteView bytes) -> Status {
    const auto now = steady_utime();
    if (count.bytes == 0) count.first_at = now;
    count.last_at = now;
    count.bytes += static_cast<std::int64_t>(bytes.size());
    return {};
  });
  count.ready = true;
  ServiceLoop loop;
  loop.buses = {bus.get()};
  loop.work = [](std::int64_t now) -> Result<std::int64_t> { return now + 500'000; };
  if (auto ended = loop.run(); !ended) give_up(ended.error().message);
  std::_Exit(0);
}

std::size_t consumers_buffer(const std::string& url) {
  return must(receive_buffer_of(must(url_at_port(url, kConsumer.port_offset()))));
}

void consume(const std::string& url, std::int64_t work_us) {
  auto bus = must(Bus::create(url));
  auto in = must(InLink::create(*bus, kConsumer, {}));
  ServiceLoop loop;
  loop.buses = {&in->port()};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    for (const auto& message : in->consumer().take()) {
      if (work_us > 0) ::usleep(static_cast<useconds_t>(work_us));
      in->consumer().commit(message.session, message.number);
    }
    if (auto pumped = in->pump(now); !pumped) return pass_on(pumped);
    return in->consumer().next_poll(now);
  };
  if (auto ended = loop.run(); !ended) give_up(ended.error().message);
  std::_Exit(0);
}

}  // namespace voxatlas::bench
