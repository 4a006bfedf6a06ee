#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/grid.hpp"
#include "octree/tile_tree.hpp"
#include "render/viewpoints.hpp"

namespace voxatlas::bench {

using Model = std::map<TileKey, TileTree>;

/// Where the scans of a model come from: a folder in KITTI form, or else the simulated drive.
struct ModelSource {
  std::string data, poses = "poses.txt";
  std::size_t scans = 1200;
  double speed = 20;  ///< Of the simulated car, metres a second: how far apart scans are.
  double azimuth_step_deg = 0.2;  ///< Of the simulated scanners.
  bool surfaces_only = false;     ///< No free space.
  /// A file that keeps the model: read where it stands, else written. Who changes one of the others
  /// must remove it.
  std::string cache;
};

Model make_model(const ModelSource& source, const Grid& grid);
std::vector<TileWeight> weigh(const Model& model);

void write_file(const std::filesystem::path& path, const Bytes& bytes);

/// An error ends a benchmark.
inline void or_throw(Status status) {
  if (!status) throw std::runtime_error(status.error().message);
}
template <class T>
T or_throw(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

}  // namespace voxatlas::bench
