#include "cli/health.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace voxatlas {

namespace {

using Level = Finding::Level;

constexpr std::size_t kGoodBufferBytes = std::size_t{2} << 20;
constexpr std::uint64_t kNoRoomBytes = std::uint64_t{256} << 20;  ///< A store needs its reserve.
constexpr std::uint64_t kLittleRoomBytes = std::uint64_t{5} << 30;
constexpr std::int64_t kClocksApartUs = 1'000'000;
constexpr std::int64_t kYear2025 = 1'735'689'600'000'000;

std::string name_of(const status_t& status) {
  return fmt::format("{} {}", status.service, status.index);
}

double counter(const status_t& status, const std::string& name) {
  const auto found = std::ranges::find(status.counters, name, &counter_t::name);
  return found == status.counters.end() ? 0 : found->value;
}

class Examination {
 public:
  explicit Examination(const HealthFacts& facts) : facts_(facts) {}

  std::vector<Finding> all() {
    bus();
    buffers();
    hub();
    services();
    doubles();
    shards();
    versions();
    losses();
    data_folder();
    disk();
    clock();
    return std::move(findings_);
  }

 private:
  void fine(std::string check, std::string what) {
    findings_.push_back({Level::kFine, std::move(check), std::move(what), ""});
  }
  void weak(std::string check, std::string what, std::string mend) {
    findings_.push_back({Level::kWeak, std::move(check), std::move(what), std::move(mend)});
  }
  void wrong(std::string check, std::string what, std::string mend) {
    findings_.push_back({Level::kWrong, std::move(check), std::move(what), std::move(mend)});
  }

  void bus();
  void buffers();
  void hub();
  void services();
  void doubles();
  void shards();
  void versions();
  void losses();
  void data_folder();
  void disk();
  void clock();
  std::set<std::int32_t> indexes_of(const std::string& service) const;

  const HealthFacts& facts_;
  std::vector<Finding> findings_;
};

void Examination::bus() {
  if (!facts_.is_multicast) return fine("route", "not needed: the bus is a hub");
  if (facts_.no_bus) {
    return wrong("route", *facts_.no_bus,
                 "As root: ip link set lo up; ip route add 224.0.0.0/4 dev lo. Or start the set "
                 "with scripts/up, which does that, or with scripts/up --hub.");
  }
  fine("route", fmt::format("{} can be joined", facts_.url));
  if (!facts_.echoed) {
    return wrong("multicast", fmt::format("60 kB sent to {} do not come back", facts_.url),
                 "Let UDP to this address pass the firewall, on the URL's port and the 1000 above "
                 "it (nft list ruleset shows the rules), or use scripts/up --hub.");
  }
  fine("multicast", "60 kB sent came back");
}

void Examination::buffers() {
  if (!facts_.is_multicast) return fine("buffers", "the hub's: a slow client loses above 16 MB");
  const auto kib = facts_.receive_buffer_bytes >> 10;
  if (facts_.receive_buffer_bytes >= kGoodBufferBytes) {
    return fine("buffers", fmt::format("a subscriber is granted {} KiB", kib));
  }
  weak(
      "buffers", fmt::format("a subscriber is granted no more than {} KiB", kib),
      "As root: sysctl -w net.core.rmem_max=4194304 (and the same in /etc/sysctl.d to keep it), "
      "then start the set again: streams get faster, and plain scans and updates are seldom lost.");
}

void Examination::hub() {
  if (facts_.is_multicast) return fine("hub", "not needed: the bus is multicast");
  if (!facts_.no_bus && facts_.echoed) {
    return fine("hub", fmt::format("60 kB sent to {} came back", facts_.url));
  }
  wrong("hub", facts_.no_bus.value_or(fmt::format("60 kB sent to {} do not come back", facts_.url)),
        "Start the set with scripts/up --hub and set LCM_DEFAULT_URL to the URL that it prints.");
}

std::set<std::int32_t> Examination::indexes_of(const std::string& service) const {
  std::set<std::int32_t> indexes;
  for (const auto& heard : facts_.services) {
    if (heard.status.service == service) indexes.insert(heard.status.index);
  }
  return indexes;
}

void Examination::services() {
  if (facts_.services.empty()) {
    return wrong("services", fmt::format("none is heard on {}", facts_.url),
                 "Start the set with scripts/up; if it runs, set LCM_DEFAULT_URL to the URL that "
                 "it printed.");
  }
  std::string ready;
  for (const auto& heard : facts_.services) {
    if (heard.status.ready == 1) {
      ready += (ready.empty() ? "" : ", ") + name_of(heard.status);
    } else {
      weak("services",
           fmt::format("{}, pid {}, is not ready: {}", name_of(heard.status), heard.status.pid,
                       heard.status.state),
           fmt::format("Wait for what it says it waits for, or read logs/{}-{}.log in the data "
                       "folder.",
                       heard.status.service, heard.status.index));
    }
  }
  if (!ready.empty()) fine("services", fmt::format("{} ready", ready));
  for (const auto& [service, without] :
       {std::pair{"tilestore", "nothing is kept"}, std::pair{"ingest", "no scan is taken"}}) {
    if (indexes_of(service).empty()) {
      wrong("services", fmt::format("no {} is heard: {}", service, without),
            fmt::format("Start one: scripts/up does, or voxatlas-{0} --help says how; its last "
                        "words are in logs/{0}-0.log in the data folder.",
                        service));
    }
  }
}

/// Two that run as the same one: they would take each other's messages.
void Examination::doubles() {
  std::map<std::string, std::set<std::int32_t>> pids;
  for (const auto& heard : facts_.services) pids[name_of(heard.status)].insert(heard.status.pid);
  for (const auto& [name, them] : pids) {
    if (them.size() < 2) continue;
    wrong("services",
          fmt::format("{} run as {}: pids {}", them.size(), name, fmt::join(them, ", ")),
          "Stop all but one, or give each set a bus of its own: another port in --url.");
  }
}

void Examination::shards() {
  const auto stores = indexes_of("tilestore");
  if (stores.empty()) return;
  for (std::int32_t shard = 0; shard < *stores.rbegin(); ++shard) {
    if (stores.contains(shard)) continue;
    wrong("services", fmt::format("tilestore {} is silent: scans that touch its tiles wait", shard),
          fmt::format("Start it again; its last words are in logs/tilestore-{}.log in the data "
                      "folder.",
                      shard));
  }
}

void Examination::versions() {
  bool all_alike = true;
  for (const auto& heard : facts_.services) {
    if (heard.status.version == facts_.version) continue;
    all_alike = false;
    weak("versions",
         fmt::format("{} is of version {}, this program of {}", name_of(heard.status),
                     heard.status.version, facts_.version),
         "Start the set again from the same build as this program.");
  }
  if (all_alike) fine("versions", fmt::format("all are of version {}", facts_.version));
}

void Examination::losses() {
  for (const auto& heard : facts_.services) {
    const auto drops = counter(heard.status, "kernel_drops");
    if (drops > 0) {
      weak("buffers",
           fmt::format("{}: the kernel has dropped {:.0f} datagrams for want of buffer",
                       name_of(heard.status), drops),
           "Nothing durable is lost by it, but time is: raise net.core.rmem_max, or give the "
           "machine less to do.");
    }
    const auto undecodable = counter(heard.status, "undecodable");
    if (undecodable > 0) {
      weak("versions",
           fmt::format("{}: {:.0f} messages could not be decoded", name_of(heard.status),
                       undecodable),
           "Another program on this bus speaks another version, or nonsense: its log names the "
           "channel. Give each set a port of its own in --url.");
    }
  }
}

void Examination::data_folder() {
  using Folder = HealthFacts::Folder;
  switch (facts_.folder) {
    case Folder::kMissing:
      return weak("data folder", fmt::format("{} is not there", facts_.data_dir),
                  "Name the set's with --data-dir; scripts/up makes one where there is none.");
    case Folder::kNoFolder:
      return wrong("data folder", fmt::format("{} is no folder", facts_.data_dir),
                   "Name another with --data-dir, here and to scripts/up.");
    case Folder::kReadOnly:
      return wrong("data folder", fmt::format("{} cannot be written", facts_.data_dir),
                   "Give it to the user who runs the set (chown -R), or mount its disk writable.");
    case Folder::kWritable:
      break;
  }
  for (std::size_t i = 0; i < facts_.shards.size(); ++i) {
    if (facts_.shards[i] == static_cast<std::int32_t>(i)) continue;
    return wrong(
        "data folder",
        fmt::format("{} has shard {} but no shard {}", facts_.data_dir, facts_.shards.back(), i),
        "Bring the missing folder back from a checkpoint (voxatlas store checkpoint).");
  }
  const auto stores = indexes_of("tilestore").size();
  if (stores > 0 && stores != facts_.shards.size()) {
    return weak("data folder",
                fmt::format("{} has {} shards, the running set {} tilestores", facts_.data_dir,
                            facts_.shards.size(), stores),
                "Name the running set's folder with --data-dir.");
  }
  fine("data folder",
       fmt::format("{} can be written and has {} shards", facts_.data_dir, facts_.shards.size()));
}

void Examination::disk() {
  const auto said = fmt::format("{:.1f} GB of {:.1f} GB are free",
                                static_cast<double>(facts_.disk_free_bytes) / 1e9,
                                static_cast<double>(facts_.disk_bytes) / 1e9);
  if (facts_.disk_free_bytes < kNoRoomBytes) {
    return wrong("disk", said,
                 "Make room where the data folder lies: until then the tile stores take nothing.");
  }
  if (facts_.disk_free_bytes < kLittleRoomBytes) {
    return weak("disk", said,
                "Make room soon, or move the model: voxatlas store checkpoint, with the set "
                "stopped, writes it elsewhere.");
  }
  fine("disk", said);
}

void Examination::clock() {
  if (facts_.utime < kYear2025) {
    return wrong(
        "clock",
        fmt::format("it says {} s since 1970, before this was written", facts_.utime / 1'000'000),
        "Set it (timedatectl set-ntp true follows a server).");
  }
  for (const auto& heard : facts_.services) {
    const auto ahead = heard.status.utime - heard.utime;
    if (ahead > -kClocksApartUs && ahead < kClocksApartUs) continue;
    return wrong("clock",
                 fmt::format("that of {} is {:.1f} s {} ours", name_of(heard.status),
                             static_cast<double>(std::max(ahead, -ahead)) / 1e6,
                             ahead > 0 ? "ahead of" : "behind"),
                 "Let all machines of the set follow one time server (timedatectl set-ntp true): "
                 "requests carry deadlines.");
  }
  if (facts_.clock_synchronised == false) {
    return weak("clock", "the kernel says that it follows no time server",
                "Where scans of several machines meet: timedatectl set-ntp true.");
  }
  fine("clock", "the services' clocks and ours agree");
}

}  // namespace

std::vector<Finding> examine(const HealthFacts& facts) { return Examination(facts).all(); }

}  // namespace voxatlas
