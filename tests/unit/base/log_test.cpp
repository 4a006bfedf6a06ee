#include "base/log.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace voxatlas {
namespace {

constexpr std::int64_t kUtime = 1'700'000'000'123'456;  // 2023-11-14 22:13:20 UTC, by date(1).
constexpr LogForm kPlain{.json = false, .journal = false};
constexpr LogForm kJson{.json = true, .journal = false};
constexpr LogForm kJournal{.json = false, .journal = true};

TEST_CASE("an event is one line with time, name and level", "[base]") {
  REQUIRE(log_text(kPlain, kUtime, "ingest[2]", "warning", "two\nlines") ==
          "2023-11-14T22:13:20.123Z ingest[2] warning: two lines");
}

TEST_CASE("the journal gets the priority and keeps time and name by itself", "[base]") {
  REQUIRE(log_text(kJournal, kUtime, "hub", "error", "disk\nfull") == "<3>disk full");
  REQUIRE(log_text(kJournal, kUtime, "hub", "warning", "slow") == "<4>slow");
  REQUIRE(log_text(kJournal, kUtime, "hub", "info", "ready") == "<6>ready");
  REQUIRE(log_text({.json = true, .journal = true}, kUtime, "hub", "info", "ready")
              .starts_with("<6>{"));
}

TEST_CASE("a JSON event is one line that a JSON parser reads back, whatever its text", "[base]") {
  const std::string hostile = "a \"quoted\" \\ back\nline\ttab \x01 and M\xc3\xbcnchen";
  const auto line = log_text(kJson, kUtime, "render[0]", "error", hostile);
  REQUIRE(line.find('\n') == std::string::npos);
  const auto event = nlohmann::json::parse(line);
  REQUIRE(event.size() == 4);
  REQUIRE(event["time"] == "2023-11-14T22:13:20.123Z");
  REQUIRE(event["service"] == "render[0]");
  REQUIRE(event["level"] == "error");
  REQUIRE(event["text"] == hostile);
}

TEST_CASE("bytes that are no UTF-8 are replaced in a JSON event, not thrown over", "[base]") {
  const auto event = nlohmann::json::parse(log_text(kJson, kUtime, "x", "info", "file \xff\xc3"));
  REQUIRE(event["text"] == "file \xef\xbf\xbd\xef\xbf\xbd");
}

TEST_CASE("of a flood of events a few lines are written, and how many were not", "[base]") {
  LogLimit limit;
  const char flood = 0, other = 0;
  constexpr std::int64_t kStart = 5'000'000'000;
  int written = 0;
  std::uint64_t left_out = 0;
  for (int i = 0; i < 60'000; ++i) {  // A thousand a second, for a minute.
    if (const auto said = limit.admit(&flood, kStart + 1'000 * i)) {
      ++written;
      left_out += *said;
    }
  }
  REQUIRE(written == 6 * LogLimit::kLines);
  REQUIRE(left_out == 5u * (10'000 - LogLimit::kLines));
  REQUIRE(limit.admit(&other, kStart + 60'000'000 - 1) == 0u);  // Another kind has its own.
  REQUIRE(limit.admit(&flood, kStart + 60'000'000) == 10'000u - LogLimit::kLines);
  REQUIRE(limit.admit(&flood, kStart + 60'000'001) == 0u);
}

}  // namespace
}  // namespace voxatlas
