#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "geodesy/ecef.hpp"
#include "grid/grid.hpp"
#include "render/camera.hpp"
#include "render/cell_cloud.hpp"

namespace voxatlas {

/// A tile and how much there is in it: occupied voxels.
struct TileWeight {
  TileKey key;
  std::uint64_t occupied = 0;
};

/// How large the pictures of a view are.
struct ViewSize {
  int width = 1280;
  int height = 720;
};

/// From above, at an angle: where most of a model lies, its long side across the picture.
/// Errors: kNotFound without any occupied tile; the Camera's.
Result<Camera> oblique_view(const Grid& grid, std::span<const TileWeight> tiles,
                            const ViewSize& size);

/// The tiles that street_view needs to see: those around the densest place. Nearest first; empty
/// where nothing is occupied.
std::vector<TileKey> street_tiles(const Grid& grid, std::span<const TileWeight> tiles);

/// From two metres above the ground, along a street: of the places and headings around the densest
/// place the one with the longest way clear ahead, roughly along the model's long horizontal axis.
/// `clouds`: of street_tiles(), at any depth from 5; the finer, the better it sees.
/// Errors: kNotFound where no place to stand is found; the Camera's.
Result<Camera> street_view(const Grid& grid, std::span<const TileWeight> tiles,
                           std::span<const PlacedCloud> clouds, const ViewSize& size);

/// From a given place, level, towards a heading: degrees from north, east is 90.
/// Errors: kOutOfRange for a place or heading that is not finite or off the Earth; the Camera's.
Result<Camera> standing_view(const Geodetic& eye, double heading_deg, const ViewSize& size);

}  // namespace voxatlas
