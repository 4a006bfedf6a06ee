// How fast reliable streams are: over multicast with the default and the largest receive buffer,
// and through the hub. Every process is real: it forks its consumers, producers and hub.
//
// Prints lines "name value unit". Multicast must work where it runs (scripts/bench sees to that).
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/service_loop.hpp"
#include "bus/stream_link.hpp"
#include "hub/hub_server.hpp"

namespace {

using namespace voxatlas;

constexpr std::size_t kMessageBytes = std::size_t{4} << 20;
/// The kernel counts the double, so this is the 208 kB that a machine grants where nobody asks.
constexpr const char* kDefaultBuffer = "&recv_buf_size=106496";

struct Options {
  std::string url = kDefaultBusUrl;
  std::int64_t megabytes = 2000;
  std::string only;
};

[[noreturn]] void give_up(const std::string& what) {
  fmt::print(stderr, "bench_bus: {}\n", what);
  std::exit(1);
}

template <class T>
T must(Result<T> result) {
  if (!result) give_up(result.error().message);
  return std::move(*result);
}

const Endpoint kConsumer{EndpointClass::kStore, 99};

template <class Child>
pid_t in_child(Child child) {
  const auto pid = ::fork();
  if (pid != 0) return pid;
  child();
  std::_Exit(0);
}

void end_child(pid_t pid) {
  ::kill(pid, SIGKILL);
  ::waitpid(pid, nullptr, 0);
}

/// Takes messages and commits them at once; `work_us` at each.
void consume(const std::string& url, std::int64_t work_us) {
  auto bus = must(Bus::create(url));
  auto in = must(InLink::create(*bus, kConsumer, {}));
  ServiceLoop loop;
  loop.buses = {&in->port()};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    for (const auto& message : in->consumer().take()) {
      const auto end = steady_utime() + work_us;
      while (steady_utime() < end) {
      }
      in->consumer().commit(message.session, message.number);
    }
    if (auto pumped = in->pump(now); !pumped) return pass_on(pumped);
    return in->consumer().next_poll(now);
  };
  if (auto ended = loop.run(); !ended) give_up(ended.error().message);
}

struct Sent {
  double seconds = 0;
  StreamProducer::Counters counters;
};

Sent produce(const std::string& url, std::int64_t messages) {
  auto bus = must(Bus::create(url));
  auto out = must(OutLink::create(*bus, kConsumer, {}));
  const Bytes payload(kMessageBytes, 0x5a);
  auto& producer = out->producer();
  const auto start = steady_utime();
  ServiceLoop loop;
  loop.buses = {bus.get()};
  loop.work = [&](std::int64_t now) -> Result<std::int64_t> {
    while (producer.offered_messages() < messages && producer.held_bytes() < 4 * kMessageBytes) {
      producer.offer(MessageKind::kScan, payload);
    }
    if (auto pumped = out->pump(now); !pumped) return pass_on(pumped);
    return producer.next_poll(steady_utime());
  };
  loop.finished = [&] { return producer.committed_messages() == messages; };
  if (auto ended = loop.run(); !ended) give_up(ended.error().message);
  return {static_cast<double>(steady_utime() - start) / 1e6, producer.counters()};
}

void one_to_one(const std::string& name, const std::string& url, std::int64_t megabytes) {
  const auto consumer = in_child([&] { consume(url, 0); });
  const auto messages = std::max<std::int64_t>(1, megabytes * 1'000'000 / kMessageBytes);
  const auto sent = produce(url, messages);
  end_child(consumer);
  const double bytes = static_cast<double>(messages) * kMessageBytes;
  fmt::print("{}_MBps {:.0f} MB/s\n", name, bytes / 1e6 / sent.seconds);
  fmt::print("{}_resent {:.3f} %\n", name,
             100.0 * static_cast<double>(sent.counters.chunks_resent) /
                 static_cast<double>(sent.counters.chunks_sent));
}

/// Eight producers on one default buffer: how fast together, and how far the slowest lags.
void eight_to_one(const std::string& url, std::int64_t megabytes) {
  const auto consumer = in_child([&] { consume(url, 0); });
  const auto messages = std::max<std::int64_t>(1, megabytes * 1'000'000 / kMessageBytes / 8);
  int pipe_fds[2];
  if (::pipe(pipe_fds) != 0) give_up("no pipe");
  std::vector<pid_t> producers;
  const auto start = steady_utime();
  for (int i = 0; i < 8; ++i) {
    producers.push_back(in_child([&] {
      const double seconds = produce(url, messages).seconds;
      if (::write(pipe_fds[1], &seconds, sizeof seconds) != sizeof seconds) give_up("pipe");
    }));
  }
  for (const auto pid : producers) ::waitpid(pid, nullptr, 0);
  const double seconds = static_cast<double>(steady_utime() - start) / 1e6;
  end_child(consumer);
  double least = 1e9, most = 0;
  for (int i = 0; i < 8; ++i) {
    double one = 0;
    if (::read(pipe_fds[0], &one, sizeof one) != sizeof one) give_up("pipe");
    least = std::min(least, one);
    most = std::max(most, one);
  }
  const double bytes = 8.0 * static_cast<double>(messages) * kMessageBytes;
  fmt::print("udpm_default_8_MBps {:.0f} MB/s\n", bytes / 1e6 / seconds);
  fmt::print("udpm_default_8_fastest_to_slowest {:.2f} ratio\n", least / most);
}

void through_hub(std::int64_t megabytes) {
  auto hub = must(HubServer::listen("127.0.0.1", 0, {}));
  const auto url = fmt::format("tcpq://127.0.0.1:{}", hub->port());
  const auto server = in_child([&] {
    while (hub->serve(500)) {
    }
  });
  one_to_one("hub", url, megabytes);
  end_child(server);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"speed of reliable streams"};
  app.add_option("--url", options.url, "multicast bus to measure on")->capture_default_str();
  app.add_option("--megabytes", options.megabytes, "to send in each case")->capture_default_str();
  app.add_option("--only", options.only, "one case: udpm_default, udpm_large, udpm_8, hub");
  CLI11_PARSE(app, argc, argv);
  const auto wanted = [&](const char* name) {
    return options.only.empty() || options.only == name;
  };
  const auto with_default = options.url + kDefaultBuffer;
  if (wanted("udpm_default")) one_to_one("udpm_default", with_default, options.megabytes);
  if (wanted("udpm_large")) one_to_one("udpm_large", options.url, options.megabytes);
  if (wanted("udpm_8")) eight_to_one(with_default, options.megabytes);
  if (wanted("hub")) through_hub(options.megabytes / 4);
  return 0;
}
