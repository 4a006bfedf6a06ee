#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "integrate/integrator.hpp"
#include "octree/tile_tree.hpp"
#include "sim/city.hpp"

namespace voxatlas::bench {

using Tiles = std::map<TileKey, TileTree>;

/// Where a voxel of a tile is, ECEF: its middle.
Eigen::Vector3d middle_of(TileKey tile, std::uint32_t code);

/// A voxel that an exact beam ended in.
struct SeenVoxel {
  Material material = Material::kAsphalt;  ///< Of the first surface seen there.
  bool moves = false;                      ///< That surface was a vehicle, driving or leaving.
  std::uint32_t seen_through = 0;          ///< In so many scans since the last beam ended there.
};

/// The voxels of a tile by their Morton code.
using SeenVoxels = std::unordered_map<std::uint32_t, SeenVoxel>;

/// What a drive really met: every voxel that holds an endpoint as it was before the noise.
class Truth {
 public:
  explicit Truth(const City& city) : city_(city) {}

  /// One scan without noise, and the city as it met it. Its endpoints, and through which voxels
  /// of vehicles that were there before it looks at 10 cm.
  void add(const Scan& exact, const Instant& instant);

  const std::map<TileKey, SeenVoxels>& tiles() const { return tiles_; }

 private:
  const City& city_;
  Integrator carver_{Grid::standard(), {kDepth, kDepth, 0, 120}};
  std::map<TileKey, SeenVoxels> tiles_;
  std::map<TileKey, std::vector<std::uint32_t>> trails_;  ///< Those of vehicles.
};

/// A way to treat free space, and the model it makes.
class Rule {
 public:
  enum class Kind {
    kDefault,  ///< 80 cm, by one ray in 80; a coarse cell with a hit of the same scan is left
               ///< alone.
    kAllRays,  ///< 80 cm, by every ray, likewise.
    kPushed,   ///< 80 cm; every coarse cell a ray passes lowers all that is in it.
    kCarve,    ///< 10 cm.
    kSurface,  ///< None.
  };
  static constexpr std::array kNames = {"default", "all_rays", "pushed", "carve", "surface"};

  explicit Rule(Kind kind);
  const char* name() const { return kNames[static_cast<std::size_t>(kind_)]; }
  void add(const Scan& noisy);
  const Tiles& tiles() const { return tiles_; }

 private:
  void push_misses(const Scan& noisy);

  Kind kind_;
  std::unique_ptr<Integrator> integrator_;
  Tiles tiles_;
};

/// How a model compares with the truth; each a share of 1.
struct Quality {
  double recall = 0;       ///< Occupied, of the voxels of things that never move.
  double poles = 0;        ///< The same of lamps' and signs' poles alone.
  double kept = 0;         ///< Occupied, of those static voxels that are so without free space:
  double kept_poles = 0;   ///< what noise has moved to the next voxel no rule could keep.
  double cleared_9 = 0;    ///< Not occupied, of voxels whose vehicle has left and that at least 9
                           ///< later scans see through: so many bring the upper clamp below 0,
  double cleared_any = 0;  ///< and of those that any later scan sees through.
  double precision = 0;    ///< Within a cell of a surface at the end, of all occupied voxels,
  double precision_then = 0;  ///< or of a vehicle that a beam met there before.
  double occupied = 0, statics = 0, pole_voxels = 0, trail_9 = 0, trail_any = 0;  ///< Of how many.
};

/// `surface`: the model without free space. `end`: the city as the last scan met it.
Quality compare(const Tiles& tiles, const Tiles& surface, const Truth& truth, const City& city,
                const Instant& end);

}  // namespace voxatlas::bench
