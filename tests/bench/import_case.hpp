#pragma once

#include <cstddef>
#include <vector>

#include "integrate/integrator.hpp"

namespace voxatlas::bench {

/// What it took. A plain value of numbers, so that a child process can hand it over a pipe.
struct ImportTiming {
  double scans = 0;                    ///< How many were imported.
  double cold_rays = 0, cold_cpu = 0;  ///< Into an empty map: the first quarter, in seconds.
  double warm_rays = 0, warm_cpu = 0;  ///< The others.
  double resident_bytes = 0;           ///< The map's, by the growth of the process.
  double delta_bytes = 0;              ///< On the wire; ours only.

  double rays() const { return cold_rays + warm_rays; }
  double cpu() const { return cold_cpu + warm_cpu; }
};

/// Integrator, then TileTree::apply, into a map of tiles; one thread.
ImportTiming import_ours(const std::vector<Scan>& scans, const IntegrationParameters& how);

/// octomap::OcTree with lazy evaluation, one update of the inner nodes and one prune at the end; a
/// second tree of 80 cm for free space where `how` has it at depth 4. Stops after `seconds`,
/// but never before four scans.
ImportTiming import_octomap(const std::vector<Scan>& scans, const IntegrationParameters& how,
                            double seconds);

/// Wall time of one worker over that of two, which integrate different scans and then apply, in
/// the order of the scans, each the tiles of its own shard: as two ingests and two stores would.
double two_threads_speedup(const std::vector<Scan>& scans, const IntegrationParameters& how);

/// Seconds of processor time of this thread; seconds of wall time; bytes resident.
double cpu_seconds();
double wall_seconds();
double resident_bytes();

/// The time of each scan, put on the cold or the warm side once their number is known.
class Stopwatch {
 public:
  void start() { started_ = cpu_seconds(); }
  void stop(std::size_t rays) {
    cpu_.push_back(cpu_seconds() - started_);
    rays_.push_back(static_cast<double>(rays));
  }
  std::size_t scans() const { return cpu_.size(); }
  double total_cpu() const;
  /// What took place since start() belongs to all scans alike.
  ImportTiming finish() const;

 private:
  double started_ = 0;
  std::vector<double> cpu_, rays_;
};

}  // namespace voxatlas::bench
