// Killed with a full journal, and opened again.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "atlas/atlas.hpp"
#include "base/utime.hpp"
#include "bench/import_scans.hpp"
#include "bench/store_case.hpp"
#include "integrate/integrator.hpp"
#include "sim/drive.hpp"
#include "store/rocksdb_store.hpp"

namespace voxatlas::bench {
namespace {

ShardScan scan_of(const ScanDelta& delta, std::int64_t seq) {
  ShardScan scan{"bench", 1, seq, {}};
  for (const auto& [key, tile] : delta.tiles) {
    Bytes bytes;
    encode_delta(tile, bytes);
    scan.deltas.emplace_back(key, std::move(bytes));
  }
  return scan;
}

/// The i-th scan of an endless drive.
using Scans = std::function<Scan(std::size_t)>;

/// Commits scans until another would no longer fit the journal, then waits to be killed. In a child
/// process; says over the pipe when it is there.
void fill_journal(const std::string& directory, const Scans& scan_at, int pipe) {
  const auto store = or_throw(RocksDbStore::open(directory));
  AtlasOptions options;
  options.cache_bytes = std::size_t{4} << 30;  // Nothing is written behind.
  const auto atlas = or_throw(Atlas::open(*store, 0, ModelParameters{}, options));
  Integrator integrator(Grid::standard(), IntegrationParameters{});
  std::size_t largest = 0;
  for (std::size_t i = 0;; ++i) {
    const auto before = atlas->stats().journal_bytes;
    if (before + 2 * largest > options.journal_max_bytes) break;
    const ShardScan scans[] = {
        scan_of(or_throw(integrator.integrate(scan_at(i))), static_cast<std::int64_t>(i))};
    or_throw(atlas->commit(scans));
    largest = std::max(largest, static_cast<std::size_t>(atlas->stats().journal_bytes - before));
  }
  const char done = 1;
  if (::write(pipe, &done, 1) != 1) _exit(3);
  for (;;) ::pause();
}

void fill_and_kill(const std::string& directory, const Scans& scans) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    ::close(ends[0]);
    try {
      fill_journal(directory, scans, ends[1]);
    } catch (const std::exception&) {
    }
    _exit(4);
  }
  ::close(ends[1]);
  char done = 0;
  const auto got = ::read(ends[0], &done, 1);
  ::close(ends[0]);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  if (got != 1) throw std::runtime_error("the writer failed");
}

}  // namespace

void simulate_and_kill(const std::string& directory) {
  const City city = or_throw(City::create({}));
  DriveOptions how;
  how.scans = 20'000;  // More than a journal holds.
  const Drive drive = or_throw(Drive::create(city, how));
  fill_and_kill(directory, [&](std::size_t i) { return to_scan(drive.simulate(i), 0.02, 0); });
}

void drive_and_kill(const std::string& directory, const std::string& data,
                    const std::string& poses) {
  constexpr std::size_t kAll = 10'000;
  const auto scans = or_throw(real_scans(data, poses, kAll));
  if (scans.empty()) throw std::runtime_error("no scans in " + data);
  fill_and_kill(directory, [&](std::size_t i) { return scans[i % scans.size()]; });
}

Opening open_after_kill(const std::string& directory) {
  const std::int64_t start = steady_utime();
  const auto store = or_throw(RocksDbStore::open(directory));
  const auto atlas = or_throw(Atlas::open(*store, 0, ModelParameters{}, AtlasOptions{}));
  Opening opening;
  opening.seconds = static_cast<double>(steady_utime() - start) / 1e6;
  const auto stats = atlas->stats();
  opening.journal_mib = static_cast<double>(stats.journal_bytes) / (1 << 20);
  opening.records = static_cast<double>(stats.replayed_records);
  opening.tiles = static_cast<double>(stats.cached_tiles + stats.tiles_flushed);
  return opening;
}

}  // namespace voxatlas::bench
