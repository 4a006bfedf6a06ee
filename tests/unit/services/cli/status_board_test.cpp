#include "cli/status_board.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

namespace voxatlas {
namespace {

status_t status(const std::string& service, std::int32_t index,
                const std::vector<std::pair<std::string, double>>& counters = {}) {
  status_t result{};
  result.service = service;
  result.index = index;
  result.pid = 4000 + index;
  result.instance = 99;
  result.version = "1.2.3";
  result.ready = 1;
  result.state = "ready";
  for (const auto& [name, value] : counters) {
    counter_t counter;
    counter.name = name;
    counter.value = value;
    result.counters.push_back(counter);
  }
  result.counters_count = static_cast<std::int32_t>(result.counters.size());
  return result;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The words of a line that stand under a heading.
std::string under(const std::vector<std::string>& lines, std::size_t line, const std::string& head,
                  const std::string& next) {
  const auto begin = lines[1].find(head), end = lines[1].find(next);
  auto text = lines[line].substr(begin, next.empty() ? std::string::npos : end - begin);
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

TEST_CASE("the table has a line a service, with its queues, credit, losses and newest scan",
          "[cli]") {
  StatusBoard board;
  board.note(status("tilestore", 1,
                    {{"epoch", 7},
                     {"queue", 3},
                     {"in_held_bytes", 1'500'000},
                     {"out_held_bytes", 500'000},
                     {"in_credit", 40},
                     {"out_credit", 2},
                     {"out_resent", 12'345},
                     {"kernel_drops", 9},
                     {"scans_applied", 38},
                     {"seq kitti_0005/123", 39},
                     {"seq other/1", 2}}),
             0);
  board.note(status("ingest", 0), 0);
  const auto lines = lines_of(board.table(0, 1000));
  REQUIRE(lines.size() == 4);
  CHECK(lines[0] == "2 of 2 services ready");
  CHECK(lines[2].starts_with("ingest 0 "));
  CHECK(lines[3].starts_with("tilestore 1 "));
  CHECK(under(lines, 3, "state", "version") == "ready");
  CHECK(under(lines, 3, "version", "     pid") == "1.2.3");
  CHECK(lines[3].find(" 4001      3   2.0M      42     12k      9  epoch 7 ") != std::string::npos);
  CHECK(under(lines, 3, "done", "newest") == "38 scans");
  CHECK(under(lines, 3, "newest", "") == "kitti_0005 #39");
  CHECK(under(lines, 2, "newest", "") == "-");
}

TEST_CASE("a service that is silent is told, and is not ready", "[cli]") {
  StatusBoard board;
  board.note(status("ingest", 0), 0);
  board.note(status("tilestore", 0), 3'000'000);
  const auto lines = lines_of(board.table(3'500'000, 1000));
  CHECK(lines[0] == "1 of 2 services ready");
  CHECK(lines[2].find("silent for 3 s") != std::string::npos);
  CHECK(board.ready(3'500'000) == 1);
  auto waiting = status("ingest", 0);
  waiting.ready = 0;
  waiting.state = "waiting for tilestore 0, which takes long";
  board.note(waiting, 3'500'000);
  CHECK(board.ready(3'500'000) == 1);
  CHECK(lines_of(board.table(3'500'000, 1000))[2].find("waiting for tilestore") !=
        std::string::npos);
}

TEST_CASE("no line is longer than the terminal is wide", "[cli]") {
  StatusBoard board;
  board.note(status("tilestore", 0, {{fmt::format("seq {:x>64}/1", ""), 5}}), 0);
  for (const auto& line : lines_of(board.table(0, 80))) CHECK(line.size() <= 80);
}

TEST_CASE("a status as JSON has all its counters, by their names", "[cli]") {
  const auto json =
      nlohmann::json::parse(status_json(status("ingest", 2, {{"rays", 1.5}, {"seq a/1", 4}})));
  CHECK(json["service"] == "ingest");
  CHECK(json["index"] == 2);
  CHECK(json["version"] == "1.2.3");
  CHECK(json["ready"] == 1);
  CHECK(json["counters"]["rays"] == 1.5);
  CHECK(json["counters"]["seq a/1"] == 4);
}

TEST_CASE("a status as a line names the service first, and has no other line in it", "[cli]") {
  const auto line = status_line(status("ingest", 2, {{"queue", 5}}));
  CHECK(line.starts_with("ingest 2 ready: pid 4002, queue 5, "));
  CHECK(line.find('\n') == std::string::npos);
}

}  // namespace
}  // namespace voxatlas
