#include "cli/health.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

using Level = Finding::Level;

constexpr std::int64_t kNow = 1'790'000'000'000'000;

HealthFacts::Heard heard(const std::string& service, std::int32_t index, std::int32_t pid) {
  HealthFacts::Heard one;
  one.status.service = service;
  one.status.index = index;
  one.status.pid = pid;
  one.status.instance = pid;
  one.status.version = "1.0";
  one.status.ready = 1;
  one.status.state = "ready";
  one.status.utime = one.utime = kNow;
  return one;
}

void count(HealthFacts::Heard& one, const std::string& name, double value) {
  counter_t counter;
  counter.name = name;
  counter.value = value;
  one.status.counters.push_back(counter);
}

/// A set with nothing wrong.
HealthFacts healthy() {
  HealthFacts facts;
  facts.url = "udpm://239.255.76.67:7667?ttl=0";
  facts.echoed = true;
  facts.receive_buffer_bytes = 8 << 20;
  facts.services = {heard("ingest", 0, 1), heard("tilestore", 0, 2), heard("tilestore", 1, 3)};
  facts.version = "1.0";
  facts.data_dir = "/data";
  facts.folder = HealthFacts::Folder::kWritable;
  facts.shards = {0, 1};
  facts.disk_free_bytes = std::uint64_t{100} << 30;
  facts.disk_bytes = std::uint64_t{200} << 30;
  facts.utime = kNow;
  facts.clock_synchronised = true;
  return facts;
}

/// The findings of a level, as "check: what -> mend".
std::vector<std::string> of_level(const HealthFacts& facts, Level level) {
  std::vector<std::string> texts;
  for (const auto& finding : examine(facts)) {
    if (finding.level != level) continue;
    texts.push_back(finding.check + ": " + finding.what + " -> " + finding.mend);
  }
  return texts;
}

/// The one thing that is not fine, which must be of this level.
std::string only(const HealthFacts& facts, Level level) {
  const auto other = level == Level::kWrong ? Level::kWeak : Level::kWrong;
  CHECK(of_level(facts, other).empty());
  const auto texts = of_level(facts, level);
  CAPTURE(texts);
  REQUIRE(texts.size() == 1);
  return texts[0];
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_CASE("of a healthy set everything is fine, and each check says so", "[cli]") {
  const auto findings = examine(healthy());
  for (const auto& check : {"route", "multicast", "buffers", "hub", "services", "versions",
                            "data folder", "disk", "clock"}) {
    CAPTURE(check);
    CHECK(std::ranges::count(findings, check, &Finding::check) == 1);
  }
  for (const auto& finding : findings) {
    CAPTURE(finding.what);
    CHECK(finding.level == Level::kFine);
    CHECK(finding.mend.empty());
  }
}

TEST_CASE("whatever is not fine comes with a sentence that mends it", "[cli]") {
  HealthFacts facts;  // Nothing works.
  facts.version = "1.0";
  facts.no_bus = "no route";
  for (const auto& finding : examine(facts)) {
    CAPTURE(finding.check, finding.what);
    CHECK((finding.level == Level::kFine) == finding.mend.empty());
    if (!finding.mend.empty()) CHECK(finding.mend.ends_with('.'));
  }
}

TEST_CASE("a bus that cannot be joined wants a route", "[cli]") {
  auto facts = healthy();
  facts.no_bus = "LCM refuses it";
  const auto text = only(facts, Level::kWrong);
  CHECK(has(text, "route: LCM refuses it"));
  CHECK(has(text, "ip route add 224.0.0.0/4 dev lo"));
}

TEST_CASE("messages that do not come back point at a firewall", "[cli]") {
  auto facts = healthy();
  facts.echoed = false;
  const auto text = only(facts, Level::kWrong);
  CHECK(has(text, "multicast: 60 kB"));
  CHECK(has(text, "firewall"));
}

TEST_CASE("a small receive buffer is weak, and the setting is named", "[cli]") {
  auto facts = healthy();
  facts.receive_buffer_bytes = 212'992 * 2;
  const auto text = only(facts, Level::kWeak);
  CHECK(has(text, "buffers: a subscriber is granted no more than 416 KiB"));
  CHECK(has(text, "net.core.rmem_max=4194304"));
}

TEST_CASE("a hub that does not answer is told, not a route", "[cli]") {
  auto facts = healthy();
  facts.is_multicast = false;
  facts.url = "tcpq://127.0.0.1:7700";
  CHECK(of_level(facts, Level::kWrong).empty());
  facts.no_bus = "no hub at tcpq://127.0.0.1:7700";
  const auto text = only(facts, Level::kWrong);
  CHECK(has(text, "hub: no hub at"));
  CHECK(has(text, "scripts/up --hub"));
}

TEST_CASE("a silent bus, a missing ingest, a missing shard are told", "[cli]") {
  auto facts = healthy();
  facts.services.clear();
  CHECK(has(only(facts, Level::kWrong), "services: none is heard on udpm://"));
  facts = healthy();
  facts.services.erase(facts.services.begin());
  CHECK(has(only(facts, Level::kWrong), "no ingest is heard"));
  facts = healthy();
  facts.services.erase(facts.services.begin() + 1);
  facts.shards = {0};  // As many as are heard.
  CHECK(has(only(facts, Level::kWrong), "tilestore 0 is silent"));
}

TEST_CASE("a service that waits is weak, and says for what", "[cli]") {
  auto facts = healthy();
  facts.services[0].status.ready = 0;
  facts.services[0].status.state = "waiting for tilestore 1";
  const auto text = only(facts, Level::kWeak);
  CHECK(has(text, "ingest 0, pid 1, is not ready: waiting for tilestore 1"));
  CHECK(has(text, "logs/ingest-0.log"));
}

TEST_CASE("two that run as the same one are told with their processes", "[cli]") {
  auto facts = healthy();
  facts.services.push_back(heard("ingest", 0, 77));
  CHECK(has(only(facts, Level::kWrong), "2 run as ingest 0: pids 1, 77"));
  // One that was started again meanwhile is not two.
  facts.services.back().status.pid = 1;
  CHECK(of_level(facts, Level::kWrong).empty());
}

TEST_CASE("another version, lost datagrams, nonsense on the bus are weak", "[cli]") {
  auto facts = healthy();
  facts.services[1].status.version = "0.9";
  CHECK(has(only(facts, Level::kWeak), "versions: tilestore 0 is of version 0.9"));
  facts = healthy();
  count(facts.services[1], "kernel_drops", 12);
  CHECK(has(only(facts, Level::kWeak), "tilestore 0: the kernel has dropped 12"));
  facts = healthy();
  count(facts.services[0], "undecodable", 3);
  CHECK(has(only(facts, Level::kWeak), "ingest 0: 3 messages could not be decoded"));
}

TEST_CASE("the data folder is there, a folder, writable, whole and the set's", "[cli]") {
  auto facts = healthy();
  facts.folder = HealthFacts::Folder::kMissing;
  CHECK(has(only(facts, Level::kWeak), "data folder: /data is not there"));
  facts.folder = HealthFacts::Folder::kNoFolder;
  CHECK(has(only(facts, Level::kWrong), "/data is no folder"));
  facts.folder = HealthFacts::Folder::kReadOnly;
  CHECK(has(only(facts, Level::kWrong), "chown"));
  facts.folder = HealthFacts::Folder::kWritable;
  facts.shards = {0, 2};
  CHECK(has(only(facts, Level::kWrong), "shard 2 but no shard 1"));
  facts.shards = {0};
  CHECK(has(only(facts, Level::kWeak), "has 1 shards, the running set 2 tilestores"));
}

TEST_CASE("a disk is full before its last byte is written", "[cli]") {
  auto facts = healthy();
  facts.disk_free_bytes = 1 << 20;
  CHECK(has(only(facts, Level::kWrong), "Make room"));
  facts.disk_free_bytes = std::uint64_t{1} << 30;
  CHECK(has(only(facts, Level::kWeak), "Make room soon"));
}

TEST_CASE("clocks apart, unset or free-running are told", "[cli]") {
  auto facts = healthy();
  facts.services[2].status.utime += 2'500'000;
  CHECK(has(only(facts, Level::kWrong), "that of tilestore 1 is 2.5 s ahead of ours"));
  facts.services[2].status.utime -= 5'000'000;
  CHECK(has(only(facts, Level::kWrong), "is 2.5 s behind ours"));
  facts = healthy();
  facts.utime = 1'000'000;
  CHECK(has(only(facts, Level::kWrong), "timedatectl"));
  facts = healthy();
  facts.clock_synchronised = false;
  CHECK(has(only(facts, Level::kWeak), "no time server"));
  facts.clock_synchronised.reset();
  CHECK(of_level(facts, Level::kWeak).empty());
}

}  // namespace
}  // namespace voxatlas
