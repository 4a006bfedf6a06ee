// How fast reliable streams are, beside LCM alone: over multicast with the default and the largest
// receive buffer, with datagrams lost, with eight producers, with a slow consumer, and through the
// hub. Every process is real: it forks its consumers, producers and hub.
//
// Prints lines "name value unit". Multicast must work where it runs, and nftables to lose datagrams
// (scripts/bench sees to that).
#include <fmt/format.h>
#include <sys/mman.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>

#include "base/utime.hpp"
#include "bus/bus_url.hpp"
#include "bus/service_main.hpp"
#include "bus_ends.hpp"
#include "hub/hub_server.hpp"

namespace voxatlas::bench {
namespace {

constexpr std::size_t kMessageBytes = std::size_t{4} << 20;
/// One chunk: the slow consumer is to hold credit back, not to wait for the rest of a message.
constexpr std::size_t kSmallBytes = 59'000;
/// The kernel counts the double, so this is the 208 kB that a machine grants where nobody asks.
constexpr const char* kDefaultBuffer = "&recv_buf_size=106496";
constexpr int kProducers = 8;
constexpr std::int64_t kSlowUs = 5'000;

struct Options {
  std::string url = kDefaultBusUrl;
  std::int64_t megabytes = 2000;
  std::string only;
};

Load load_of(std::int64_t megabytes) {
  return {std::max<std::int64_t>(1, megabytes * 1'000'000 / std::int64_t{kMessageBytes}),
          kMessageBytes};
}

void print(const std::string& name, const char* what, double value, const char* unit) {
  fmt::print("{}_{} {:.4g} {}\n", name, what, value, unit);
  std::fflush(stdout);
}

/// A target that was missed is said so, on standard error: the figures stay what they are.
void judge(const std::string& name, double MBps, double least) {
  if (MBps >= least) return;
  fmt::print(stderr, "bench_bus: {}_MBps is {:.4g}, the target is {}\n", name, MBps, least);
}

void one_to_one(const std::string& name, const std::string& url, std::int64_t megabytes,
                double least_MBps = 0) {
  const auto consumer = in_child([&] { consume(url, 0); });
  const auto load = load_of(megabytes);
  const auto sent = produce(url, load);
  const auto took = end_child(consumer);
  const double MB = static_cast<double>(load.messages) * kMessageBytes / 1e6;
  print(name, "MBps", MB / sent.seconds, "MB/s");
  judge(name, MB / sent.seconds, least_MBps);
  print(name, "resent",
        100.0 * static_cast<double>(sent.chunks_resent) / static_cast<double>(sent.chunks_sent),
        "%");
  print(name, "producer_cpu", 100 * sent.cpu_seconds / sent.seconds, "%");
  print(name, "consumer_cpu", 100 * took.cpu_seconds / sent.seconds, "%");
  print(name, "ack_bytes_per_MB", static_cast<double>(sent.ack_bytes) / MB, "bytes");
}

template <class T>
T& shared_with_children() {
  auto* shared =
      ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) give_up("no memory to share");
  return *new (shared) T;  // Until the process ends.
}

/// The ceiling of all that follows: LCM alone, which loses what its reader does not fetch in time.
void raw(const std::string& url, std::int64_t megabytes) {
  auto& count = shared_with_children<RawCount>();
  const auto consumer = in_child([&] { count_raw(url, count); });
  while (!count.ready) ::usleep(1000);
  const Load load{megabytes * 1'000'000 / std::int64_t{kSmallBytes}, kSmallBytes};
  const auto sent = publish_raw(url, load);
  const auto took = end_child(consumer);
  const double MB = static_cast<double>(load.messages) * kSmallBytes / 1e6;
  const double got_MB = static_cast<double>(count.bytes) / 1e6;
  const double seconds = static_cast<double>(count.last_at - count.first_at) / 1e6;
  print("udpm_raw", "sent_MBps", MB / sent.seconds, "MB/s");
  print("udpm_raw", "received_MBps", got_MB / seconds, "MB/s");
  print("udpm_raw", "lost", 100 * (1 - got_MB / MB), "%");
  print("udpm_raw", "producer_cpu", 100 * sent.cpu_seconds / sent.seconds, "%");
  print("udpm_raw", "consumer_cpu", 100 * took.cpu_seconds / sent.seconds, "%");
}

void run_nft(const std::string& arguments) {
  if (std::system(("nft " + arguments).c_str()) != 0) give_up("nft " + arguments + " failed");
}

/// A datagram in twenty is lost before it reaches a socket, chunks and acknowledgements alike.
void one_to_one_at_drop(const std::string& url, std::int64_t megabytes) {
  run_nft(
      "'add table inet voxatlas_bench; add chain inet voxatlas_bench in "
      "{ type filter hook input priority 0; }; add rule inet voxatlas_bench in "
      "ip protocol udp numgen random mod 100 < 5 drop'");
  one_to_one("udpm_drop5", url, megabytes, 100);
  run_nft("delete table inet voxatlas_bench");
}

/// Eight producers on one default buffer: how fast together, and how far the slowest lags.
void eight_to_one(const std::string& url, std::int64_t megabytes) {
  const auto consumer = in_child([&] { consume(url, 0); });
  const auto load = load_of(megabytes / kProducers);
  auto& sent = shared_with_children<std::array<Sent, kProducers>>();
  std::array<pid_t, kProducers> producers{};
  const auto start = steady_utime();
  for (std::size_t i = 0; i < kProducers; ++i) {
    producers[i] = in_child([&] { sent[i] = produce(url, load); });
  }
  for (const auto pid : producers) wait_for_child(pid);
  const double seconds = static_cast<double>(steady_utime() - start) / 1e6;
  end_child(consumer);
  const auto [fastest, slowest] = std::ranges::minmax_element(sent, {}, &Sent::seconds);
  std::uint64_t resent = 0;
  for (const auto& one : sent) resent += one.chunks_resent;
  print("udpm_default_8", "MBps",
        kProducers * static_cast<double>(load.messages) * kMessageBytes / 1e6 / seconds, "MB/s");
  print("udpm_default_8", "fastest_to_slowest", fastest->seconds / slowest->seconds, "ratio");
  print("udpm_default_8", "chunks_resent", static_cast<double>(resent), "chunks");
}

/// A consumer that works 5 ms on each message sets the pace, and nobody's memory grows meanwhile.
void to_slow_consumer(const std::string& url, std::int64_t megabytes) {
  const auto consumer = in_child([&] { consume(url, kSlowUs); });
  const Load load{std::max<std::int64_t>(40, megabytes * 3 / 4), kSmallBytes};
  const auto sent = produce(url, load);
  const auto took = end_child(consumer);
  print("udpm_slow", "ms_per_message", 1e3 * sent.seconds / static_cast<double>(load.messages),
        "ms");
  print("udpm_slow", "chunks_resent", static_cast<double>(sent.chunks_resent), "chunks");
  print("udpm_slow", "producer_grew", sent.late_MB - sent.early_MB, "MB");
  print("udpm_slow", "consumer_peak", took.peak_MB, "MB");
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

void run(const Options& options) {
  const auto wanted = [&](const char* name) {
    return options.only.empty() || options.only == name;
  };
  if (wanted("udpm_raw")) raw(options.url, options.megabytes);
  const auto with_default = options.url + kDefaultBuffer;
  if (wanted("udpm_default")) one_to_one("udpm_default", with_default, options.megabytes, 500);
  if (wanted("udpm_large")) {
    print("udpm_large", "receive_buffer", static_cast<double>(consumers_buffer(options.url)) / 1e6,
          "MB");
    one_to_one("udpm_large", options.url, options.megabytes, 1500);
  }
  if (wanted("udpm_drop5")) one_to_one_at_drop(options.url, options.megabytes / 2);
  if (wanted("udpm_8")) eight_to_one(with_default, options.megabytes);
  if (wanted("udpm_slow")) to_slow_consumer(options.url, options.megabytes);
  if (wanted("hub")) through_hub(options.megabytes / 4);
}

}  // namespace
}  // namespace voxatlas::bench

int main(int argc, char** argv) {
  voxatlas::bench::Options options;
  CLI::App app{"speed of reliable streams"};
  app.add_option("--url", options.url, "multicast bus to measure on")->capture_default_str();
  app.add_option("--megabytes", options.megabytes, "to send in each case")->capture_default_str();
  app.add_option("--only", options.only, "one case")
      ->check(CLI::IsMember(
          {"udpm_raw", "udpm_default", "udpm_large", "udpm_drop5", "udpm_8", "udpm_slow", "hub"}));
  CLI11_PARSE(app, argc, argv);
  voxatlas::keep_freed_memory();  // As every service does.
  voxatlas::bench::run(options);
  return 0;
}
