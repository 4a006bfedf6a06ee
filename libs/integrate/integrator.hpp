#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "grid/grid.hpp"
#include "integrate/scan.hpp"
#include "octree/tile_delta.hpp"

namespace voxatlas {

/// How scans become cells. Part of a model's parameters: all ingests of a model use the same.
struct IntegrationParameters {
  static constexpr int kNoFreeSpace = -1;
  static constexpr double kLongestRange = 1000;

  int free_depth = 4;          ///< Depth of free space, 0..7, or kNoFreeSpace: surface only.
  int surface_depth = kDepth;  ///< No hit goes deeper than this, 0..7.
  double min_range = 0;        ///< Metres; rays that end nearer are dropped. 0: none are.
  double max_range = 120;      ///< Metres, at most 1000; beyond it a ray only frees, up to it.
  bool all_rays_free = false;  ///< As in the paper; else only some where free space is coarser than
                               ///< hits (free_rays.hpp), so that less of what is there is erased.

  /// Errors: kOutOfRange, naming the value that is not as above (max_range > min_range >= 0).
  Status check() const;
  friend bool operator==(const IntegrationParameters&, const IntegrationParameters&) = default;
};

/// What became of a scan's rays.
struct IntegrationCounts {
  std::uint64_t rays = 0;          ///< All endpoints of the scan; the other counts are parts of it.
  std::uint64_t hits = 0;          ///< Ended in a hit cell.
  std::uint64_t beyond_max = 0;    ///< Cut at max_range: free space only.
  std::uint64_t below_min = 0;     ///< Dropped.
  std::uint64_t not_finite = 0;    ///< Dropped.
  std::uint64_t off_cube = 0;      ///< Dropped: the end (after the cut) is off the index cube.
  std::uint64_t cells_missed = 0;  ///< Cells in the deltas' misses, after deduplication.
  std::uint64_t cells_hit = 0;

  IntegrationCounts& operator+=(const IntegrationCounts& other);
};

/// A scan's deltas, ascending by tile, none empty.
struct ScanDelta {
  std::vector<std::pair<TileKey, TileDelta>> tiles;
  IntegrationCounts counts;
};

/// Turns scans into tile deltas: the paper's Algorithm 1 with ray-based key buffering.
///
/// Source:  the paper's sections 4.1 and 4.2; DESIGN section 4, every rule of it.
/// Rules:   hits at depth min(eq. (5), surface_depth); misses at min(free_depth, eq. (5)). Per scan
///          every cell counts once, hits win, also across tile borders. A miss cell that equals,
///          contains or lies inside a hit cell is dropped. Coarse misses come of a part of the rays
///          alone (free_rays.hpp) unless all_rays_free. The origin's cell is a miss; beyond
///          max_range the cut ray's end cell is left alone. A cell's colour is the mean, rounded to
///          nearest, of its coloured points.
/// Result:  depends on nothing but the scan and the parameters: the same bytes anywhere.
/// Errors:  kOutOfRange for a sigma eq. (5) refuses, an origin off the cube, a min_range that is
///          negative or NaN, or colours whose number differs from the endpoints'; nothing is
///          integrated then.
/// Threads: one scan at a time; it keeps its buffers between scans. Use one a worker.
class Integrator {
 public:
  /// The parameters must pass check().
  Integrator(const Grid& grid, const IntegrationParameters& parameters);
  ~Integrator();

  Result<ScanDelta> integrate(const Scan& scan);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
