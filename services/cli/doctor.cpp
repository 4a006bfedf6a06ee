#include "cli/doctor.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "base/utime.hpp"
#include "bus/bus.hpp"
#include "bus/bus_url.hpp"
#include "bus/channels.hpp"
#include "bus/service_loop.hpp"
#include "cli/health.hpp"
#include "cli/json_text.hpp"

namespace voxatlas {

namespace {

/// Joins the bus, tries it, and hears who is on it.
Status look_at_bus(const DoctorOptions& options, HealthFacts& facts) {
  auto url = BusUrl::parse(options.url);
  if (!url) return pass_on(url);  // A mistake of who asks, not of the machine.
  facts.url = url->to_string();
  facts.is_multicast = url->is_multicast();
  if (auto granted = receive_buffer_of(url->with_large_buffer().to_string())) {
    facts.receive_buffer_bytes = *granted;
  }
  auto bus = Bus::create(options.url);
  if (!bus) {
    facts.no_bus = bus.error().message;
    return {};
  }
  std::map<std::int64_t, HealthFacts::Heard> heard;  // By instance.
  (*bus)->subscribe<status_t>(kStatusChannel, [&](const status_t& status) {
    constexpr std::size_t kMost = 1000;
    if (heard.size() < kMost) heard[status.instance] = {status, utime_now()};
  });
  // LCM tries a multicast bus itself when it subscribes, and waits ten seconds for the echo.
  facts.echoed = (*bus)->handle_waiting().has_value() && probe_bus(options.url).has_value();
  if (!facts.echoed) return {};
  ServiceLoop loop;
  loop.buses = {bus->get()};
  const auto until = steady_utime() + static_cast<std::int64_t>(options.listen * 1e6);
  loop.work = [&](std::int64_t) -> Result<std::int64_t> { return until; };
  loop.finished = [&] { return steady_utime() >= until; };
  if (auto ran = loop.run(); !ran) facts.echoed = false;
  constexpr std::int64_t kGoneUs = 1'200'000;  // Two statuses: it was stopped, or started again.
  for (auto& [instance, one] : heard) {
    if (utime_now() - one.utime < kGoneUs) facts.services.push_back(std::move(one));
  }
  std::ranges::sort(facts.services, {}, [](const auto& one) {
    return std::pair(one.status.service, one.status.index);
  });
  return {};
}

/// The number in "shard-12"; nothing for another name.
std::optional<std::int32_t> shard_number(const std::string& name) {
  constexpr std::string_view kPrefix = "shard-";
  std::int32_t number = 0;
  if (!name.starts_with(kPrefix)) return std::nullopt;
  const char* const end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + kPrefix.size(), end, number);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return std::nullopt;
  return number;
}

void look_at_folder(const std::string& data_dir, HealthFacts& facts) {
  namespace fs = std::filesystem;
  using Folder = HealthFacts::Folder;
  std::error_code ignored;
  fs::path folder = fs::absolute(data_dir, ignored);
  facts.data_dir = folder.string();
  if (fs::is_directory(folder, ignored)) {
    facts.folder =
        ::access(folder.c_str(), R_OK | W_OK | X_OK) == 0 ? Folder::kWritable : Folder::kReadOnly;
    for (fs::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored)) {
      if (const auto shard = shard_number(it->path().filename())) facts.shards.push_back(*shard);
    }
    std::ranges::sort(facts.shards);
  } else {
    facts.folder = fs::exists(folder, ignored) ? Folder::kNoFolder : Folder::kMissing;
  }
  while (!fs::exists(folder, ignored) && folder.has_relative_path()) folder = folder.parent_path();
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) == 0) {
    facts.disk_free_bytes = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    facts.disk_bytes = std::uint64_t{disk.f_blocks} * disk.f_frsize;
  }
}

void look_at_clock(HealthFacts& facts) {
  facts.utime = utime_now();
  timex kernel{};  // modes 0: only asks.
  const int state = ::adjtimex(&kernel);
  if (state >= 0) facts.clock_synchronised = state != TIME_ERROR && !(kernel.status & STA_UNSYNC);
}

const char* word_of(Finding::Level level) {
  switch (level) {
    case Finding::Level::kFine:
      return "fine";
    case Finding::Level::kWeak:
      return "weak";
    case Finding::Level::kWrong:
      return "wrong";
  }
  return "";
}

void print(const Finding& finding, bool json) {
  const char* word = word_of(finding.level);
  if (json) {
    JsonObject line;
    line.add("level", std::string(word)).add("check", finding.check).add("what", finding.what);
    line.add("mend", finding.mend);
    fmt::print("{}\n", line.text());
    return;
  }
  fmt::print("{:<6}{:<12} {}\n", word, finding.check, finding.what);
  if (!finding.mend.empty()) fmt::print("{:<19}-> {}\n", "", finding.mend);
}

}  // namespace

Status run_doctor(const DoctorOptions& options) {
  HealthFacts facts;
  facts.version = voxatlas_version();
  if (auto looked = look_at_bus(options, facts); !looked) return looked;
  look_at_folder(options.data_dir, facts);
  look_at_clock(facts);
  const auto findings = examine(facts);
  for (const auto& finding : findings) print(finding, options.json);
  const auto wrong = std::ranges::count(findings, Finding::Level::kWrong, &Finding::level);
  if (wrong == 0) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{} of {} findings must be mended", wrong, findings.size()));
}

}  // namespace voxatlas
