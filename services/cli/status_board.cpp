#include "cli/status_board.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "base/utime.hpp"
#include "cli/json_text.hpp"

namespace voxatlas {

namespace {

/// The counters a person wants to see first; `--json` gives all.
constexpr std::array<std::string_view, 9> kShown = {
    "scans_acknowledged", "scans_in_flight", "rays",   "scans_applied", "dirty_tiles",
    "cached_bytes",       "tiles",           "frames", "refused"};

std::string shown_counters(const status_t& status) {
  std::string text;
  for (const auto& counter : status.counters) {
    if (std::ranges::find(kShown, counter.name) == kShown.end()) continue;
    text += fmt::format("{}{} {:.0f}", text.empty() ? "" : ", ", counter.name, counter.value);
  }
  return text;
}

}  // namespace

void StatusBoard::note(const status_t& status, std::int64_t now) {
  const auto key = std::pair{status.service, status.index};
  if (services_.size() >= kMaxServices && !services_.contains(key)) return;
  services_[key] = {status, now};
}

std::int64_t StatusBoard::ready(std::int64_t now) const {
  return std::ranges::count_if(services_, [&](const auto& entry) {
    return entry.second.status.ready == 1 && now - entry.second.heard < kSilence;
  });
}

void StatusBoard::print(const status_t& status, bool json) const {
  if (json) {
    JsonObject counters;
    for (const auto& counter : status.counters) counters.add(counter.name, counter.value);
    JsonObject line;
    line.add("service", status.service)
        .add("index", std::int64_t{status.index})
        .add("pid", std::int64_t{status.pid})
        .add("instance", status.instance)
        .add("version", status.version)
        .add("ready", std::int64_t{status.ready})
        .add("state", status.state)
        .add("counters", counters);
    fmt::print("{}\n", line.text());
  } else if (isatty(STDOUT_FILENO) == 1) {
    fmt::print("\x1b[H\x1b[J{}", table(steady_utime()));  // From the top, the rest cleared.
  } else {
    fmt::print("{}[{}] {}: {}\n", status.service, status.index, status.state,
               shown_counters(status));
  }
}

std::string StatusBoard::table(std::int64_t now) const {
  std::string text = fmt::format("{:<14}{:>8}  {:<28}{}\n", "service", "pid", "state", "counters");
  for (const auto& [key, entry] : services_) {
    const bool silent = now - entry.heard >= kSilence;
    text += fmt::format("{:<14}{:>8}  {:<28}{}\n", fmt::format("{}[{}]", key.first, key.second),
                        entry.status.pid, silent ? "silent" : entry.status.state,
                        shown_counters(entry.status));
  }
  return text;
}

}  // namespace voxatlas
