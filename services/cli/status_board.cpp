#include "cli/status_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/json_text.hpp"

namespace voxatlas {

namespace {

constexpr std::string_view kSeq = "seq ";  // As SourceMarks names them.

std::optional<double> counter(const status_t& status, std::string_view name) {
  const auto found = std::ranges::find(status.counters, name, &counter_t::name);
  if (found == status.counters.end()) return std::nullopt;
  return found->value;
}

/// 950, 12k, 3.4M: never more than five characters.
std::string short_number(double value) {
  constexpr std::array<const char*, 5> kUnits = {"", "k", "M", "G", "T"};
  std::size_t unit = 0;
  for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
  return fmt::format("{:.{}f}{}", value, unit > 0 && value < 9.95 ? 1 : 0, kUnits[unit]);
}

/// The sum of those counters that a service has; "-" where it has none.
std::string sum_of(const status_t& status, std::initializer_list<std::string_view> names) {
  std::optional<double> sum;
  for (const auto name : names) {
    if (const auto value = counter(status, name)) sum = sum.value_or(0) + *value;
  }
  return sum ? short_number(*sum) : "-";
}

/// What it has done, in its own unit.
std::string work_of(const status_t& status) {
  constexpr std::array<std::string_view, 5> kWork = {"scans_acknowledged", "scans_applied", "tiles",
                                                     "frames", "messages"};
  for (const auto name : kWork) {
    const auto value = counter(status, name);
    if (value) return fmt::format("{} {}", short_number(*value), name.substr(0, name.find('_')));
  }
  return "-";
}

/// The newest scan of the source heard of last, such as "kitti_0005 #39".
std::string newest_scan(const status_t& status) {
  for (const auto& one : status.counters) {
    if (!one.name.starts_with(kSeq)) continue;
    const auto slash = one.name.rfind('/');
    const auto source = one.name.substr(kSeq.size(), slash - kSeq.size());
    return fmt::format("{} #{:.0f}", source, one.value);
  }
  return "-";
}

std::string lease_of(const status_t& status) {
  const auto epoch = counter(status, "epoch");
  return epoch ? fmt::format("epoch {:.0f}", *epoch) : "-";
}

template <class... Columns>
std::string row(const Columns&... columns) {
  return fmt::format("{:<14.13}{:<24.23}{:<9}{:>8}{:>7}{:>7}{:>8}{:>8}{:>7}  {:<10}{:<18}{}",
                     columns...);
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

std::string StatusBoard::table(std::int64_t now, std::size_t width) const {
  std::vector<std::string> lines = {
      fmt::format("{} of {} services ready", ready(now), services_.size()),
      row("service", "state", "version", "pid", "queue", "held", "credit", "resent", "drops",
          "lease", "done", "newest scan")};
  for (const auto& [key, entry] : services_) {
    const auto& status = entry.status;
    const auto silence = now - entry.heard;
    lines.push_back(row(
        fmt::format("{} {}", key.first, key.second),
        silence >= kSilence ? fmt::format("silent for {} s", silence / 1'000'000) : status.state,
        status.version, status.pid, sum_of(status, {"queue", "scans_waiting", "requests_waiting"}),
        sum_of(status, {"in_held_bytes", "out_held_bytes"}),
        sum_of(status, {"in_credit", "out_credit"}), sum_of(status, {"out_resent"}),
        sum_of(status, {"kernel_drops", "dropped"}), lease_of(status), work_of(status),
        newest_scan(status)));
  }
  std::string text;
  for (const auto& line : lines) text += line.substr(0, width) + "\n";
  return text;
}

std::string status_line(const status_t& status) {
  return fmt::format(
      "{} {} {}: pid {}, queue {}, held {}, credit {}, resent {}, drops {}, lease {}, done {}, "
      "newest scan {}",
      status.service, status.index, status.state, status.pid,
      sum_of(status, {"queue", "scans_waiting", "requests_waiting"}),
      sum_of(status, {"in_held_bytes", "out_held_bytes"}),
      sum_of(status, {"in_credit", "out_credit"}), sum_of(status, {"out_resent"}),
      sum_of(status, {"kernel_drops", "dropped"}), lease_of(status), work_of(status),
      newest_scan(status));
}

std::string status_json(const status_t& status) {
  JsonObject counters;
  for (const auto& one : status.counters) counters.add(one.name, one.value);
  JsonObject line;
  line.add("service", status.service)
      .add("index", std::int64_t{status.index})
      .add("utime", status.utime)
      .add("pid", std::int64_t{status.pid})
      .add("instance", status.instance)
      .add("version", status.version)
      .add("ready", std::int64_t{status.ready})
      .add("state", status.state)
      .add("counters", counters);
  return line.text();
}

}  // namespace voxatlas
