#include "bus/lcm_log.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "support/engine.hpp"
#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

struct Written {
  std::int64_t utime = 0;
  std::string channel;
  Bytes data;
  std::size_t begin = 0, end = 0;  ///< In the file.

  friend bool operator==(const Written& a, const Written& b) {
    return a.utime == b.utime && a.channel == b.channel && a.data == b.data;
  }
};

Bytes file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

void write_bytes(const std::string& path, ByteView bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << as_text(bytes);
}

/// The golden log: events of all sizes, written by LCM itself.
std::vector<Written> write_log(const std::string& path, std::size_t events, std::mt19937_64& rng) {
  std::vector<Written> written;
  {
    lcm::LogFile log(path, "w");
    REQUIRE(log.good());
    for (std::size_t i = 0; i < events; ++i) {
      Written one;
      one.utime = 1'700'000'000'000'000 + static_cast<std::int64_t>(rng() % 1'000'000);
      one.channel = std::string(1 + rng() % 40, static_cast<char>('A' + i % 26));
      one.data.resize(rng() % 300);
      for (auto& byte : one.data) byte = static_cast<std::uint8_t>(rng());
      one.begin = i == 0 ? 0 : written.back().end;
      one.end = one.begin + 28 + one.channel.size() + one.data.size();
      lcm::LogEvent event{};
      event.timestamp = one.utime;
      event.channel = one.channel;
      event.datalen = static_cast<std::int32_t>(one.data.size());
      event.data = one.data.data();
      REQUIRE(log.writeEvent(&event) == 0);
      written.push_back(std::move(one));
    }
  }
  REQUIRE(std::filesystem::file_size(path) == written.back().end);
  return written;
}

struct Got {
  std::vector<Written> events;
  std::optional<Error> damage;
};

Got read_log(const std::string& path) {
  auto log = LcmLog::open(path).value();
  Got got;
  while (auto event = log.next().value()) {
    REQUIRE(event->size <= log.file_bytes());  // No length of a hostile file is believed.
    got.events.push_back({event->utime, event->channel, log.read(*event).value()});
    REQUIRE(got.events.back().data.size() == event->size);
  }
  REQUIRE(log.position() == log.file_bytes());
  got.damage = log.damage();
  return got;
}

/// Whether `events` holds all of `wanted`, in their order.
bool holds(const std::vector<Written>& events, const std::vector<Written>& wanted) {
  auto at = events.begin();
  for (const auto& one : wanted) {
    at = std::find(at, events.end(), one);
    if (at == events.end()) return false;
    ++at;
  }
  return true;
}

TEST_CASE("a log that LCM wrote is read event by event", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir dir;
  const auto written = write_log(dir / "log", 500, rng);

  const auto got = read_log(dir / "log");

  REQUIRE(got.events == written);
  REQUIRE_FALSE(got.damage.has_value());
}

TEST_CASE("events of a log are read again in any order", "[bus]") {
  auto rng = test::engine();
  const test::TempDir dir;
  const auto written = write_log(dir / "log", 50, rng);
  auto log = LcmLog::open(dir / "log").value();
  std::vector<LcmLog::Event> events;
  while (auto event = log.next().value()) events.push_back(*event);
  REQUIRE(events.size() == written.size());

  for (int i = 0; i < 200; ++i) {
    const std::size_t wanted = rng() % events.size();
    REQUIRE(log.read(events[wanted]).value() == written[wanted].data);
  }
}

TEST_CASE("a log cut off anywhere gives the events before, and says so", "[bus][hostile]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir dir;
  const auto written = write_log(dir / "log", 40, rng);
  const Bytes whole = file_bytes(dir / "log");

  for (std::size_t cut = 0; cut < whole.size(); cut += 7) {
    write_bytes(dir / "cut", ByteView(whole).first(cut));
    std::vector<Written> expected;
    for (const auto& one : written) {
      if (one.end <= cut) expected.push_back(one);
    }
    const bool between = cut == (expected.empty() ? 0 : expected.back().end);

    const auto got = read_log(dir / "cut");

    INFO("cut at " << cut);
    REQUIRE(got.events == expected);
    REQUIRE(got.damage.has_value() != between);
    if (!between) REQUIRE(got.damage->code == ErrorCode::kCorrupt);
  }
}

TEST_CASE("random bytes in a log cost the events they hit, and no other", "[bus][hostile]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const test::TempDir dir;
  const auto written = write_log(dir / "log", 40, rng);
  const Bytes whole = file_bytes(dir / "log");

  for (int round = 0; round < 1'000; ++round) {
    Bytes bytes = whole;
    const std::size_t begin = rng() % bytes.size();
    const std::size_t end = std::min(bytes.size(), begin + 1 + rng() % 400);
    for (std::size_t i = begin; i < end; ++i) bytes[i] = static_cast<std::uint8_t>(rng());
    write_bytes(dir / "hit", bytes);
    std::vector<Written> untouched;
    bool is_sync_hit = false;
    for (const auto& one : written) {
      if (one.end <= begin || one.begin >= end) untouched.push_back(one);
      // All four bytes: of fewer, each may by chance have become what it was.
      is_sync_hit |= begin <= one.begin && one.begin + 4 <= end;
    }

    const auto got = read_log(dir / "hit");

    INFO("bytes " << begin << " to " << end);
    REQUIRE(holds(got.events, untouched));
    if (is_sync_hit) REQUIRE(got.damage.has_value());
  }
}

TEST_CASE("what is no log gives no event and takes no memory", "[bus][hostile]") {
  auto rng = test::engine();
  const test::TempDir dir;
  Bytes noise(100'000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(rng());
  write_bytes(dir / "noise", noise);
  REQUIRE(read_log(dir / "noise").events.empty());
  REQUIRE(read_log(dir / "noise").damage->code == ErrorCode::kCorrupt);

  // One header that promises 2 GB, and one of a negative length.
  for (const std::uint8_t top : {std::uint8_t{0x7f}, std::uint8_t{0xff}}) {
    Bytes hostile = {0xed, 0xa1, 0xda, 0x01};
    hostile.resize(200);
    hostile[23] = 1;
    hostile[24] = top;
    hostile[25] = hostile[26] = hostile[27] = 0xff;
    write_bytes(dir / "hostile", hostile);
    REQUIRE(read_log(dir / "hostile").events.empty());
    REQUIRE(read_log(dir / "hostile").damage.has_value());
  }
}

TEST_CASE("a log within a message of a log is that message's", "[bus][hostile]") {
  auto rng = test::engine();
  const test::TempDir dir;
  write_log(dir / "inner", 5, rng);
  {
    lcm::LogFile log(dir / "outer", "w");
    Bytes data = file_bytes(dir / "inner");
    for (int i = 0; i < 3; ++i) {
      lcm::LogEvent event{};
      event.channel = "FILE";
      event.datalen = static_cast<std::int32_t>(data.size());
      event.data = data.data();
      REQUIRE(log.writeEvent(&event) == 0);
    }
  }

  const auto got = read_log(dir / "outer");

  REQUIRE(got.events.size() == 3);
  REQUIRE(got.events.back().data == file_bytes(dir / "inner"));
  REQUIRE_FALSE(got.damage.has_value());
}

TEST_CASE("a log is known by its first bytes or its name", "[bus]") {
  auto rng = test::engine();
  const test::TempDir dir;
  write_log(dir / "log", 1, rng);
  write_bytes(dir / "empty.lcm", {});
  write_bytes(dir / "text", as_bytes("no log"));

  REQUIRE(is_lcm_log(dir / "log"));
  REQUIRE(is_lcm_log(dir / "empty.lcm"));
  REQUIRE_FALSE(is_lcm_log(dir / "text"));
  REQUIRE_FALSE(is_lcm_log(dir / ""));
  REQUIRE_FALSE(is_lcm_log(dir / "nowhere.lcm"));
  REQUIRE(LcmLog::open(dir / "nowhere").error().code == ErrorCode::kNotFound);
  REQUIRE(LcmLog::open(dir / "").error().code == ErrorCode::kInvalid);
}

}  // namespace
}  // namespace voxatlas
