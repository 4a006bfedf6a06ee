#include "bench/render_model.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <future>

#include "codec/tile_codec.hpp"
#include "integrate/integrator.hpp"
#include "io/kitti.hpp"
#include "sim/drive.hpp"

namespace voxatlas::bench {
namespace {

constexpr std::uint64_t kTileBytes = 1u << 26;  // No tile is larger by far.

using EachScan = std::function<void(const SensorScan&)>;

void read_scans(const ModelSource& source, const EachScan& each) {
  const auto folder = or_throw(KittiFolder::open(source.data, {source.poses, std::nullopt}));
  for (std::size_t i = 0; i < std::min(source.scans, folder.scan_count()); ++i) {
    each(or_throw(folder.read(i)).scan);
  }
}

/// Two at a time: simulating takes longer than integrating.
void simulate_scans(const ModelSource& source, const EachScan& each) {
  const City city = or_throw(City::create({}));
  DriveOptions how;
  how.scans = source.scans;
  how.speed = source.speed;
  how.azimuth_step_deg = source.azimuth_step_deg;
  const Drive drive = or_throw(Drive::create(city, how));
  for (std::size_t i = 0; i < drive.scan_count(); i += 2) {
    std::future<SensorScan> second;
    if (i + 1 < drive.scan_count()) {
      second = std::async(std::launch::async, [&drive, i] { return drive.simulate(i + 1); });
    }
    each(drive.simulate(i));
    if (second.valid()) each(second.get());
  }
}

/// Of the city the surfaces alone, unless free space is to be seen: much faster.
Model integrate(const ModelSource& source, const Grid& grid) {
  IntegrationParameters parameters;
  if (source.surfaces_only) parameters.free_depth = IntegrationParameters::kNoFreeSpace;
  Integrator integrator(grid, parameters);
  Model model;
  const auto each = [&](const SensorScan& scan) {
    const auto delta = or_throw(integrator.integrate(to_scan(scan, 0.02, 2.5)));
    for (const auto& [key, tile] : delta.tiles) model[key].apply(tile, SensorModel::standard());
  };
  source.data.empty() ? simulate_scans(source, each) : read_scans(source, each);
  return model;
}

/// Key, length, bytes of each tile, as this machine writes numbers: for the same machine alone.
struct TileHead {
  std::uint64_t key, bytes;
};

void keep(const Model& model, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  for (const auto& [key, tree] : model) {
    const Bytes bytes = encode_tile(tree, {});
    const TileHead head{key.morton(), bytes.size()};
    out.write(reinterpret_cast<const char*>(&head), sizeof head);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  }
  if (!out) throw std::runtime_error("cannot write " + path);
}

Model read_kept(const std::string& path, const Grid& grid) {
  std::ifstream in(path, std::ios::binary);
  Model model;
  for (TileHead head{}; in.read(reinterpret_cast<char*>(&head), sizeof head);) {
    if (head.bytes > kTileBytes) throw std::runtime_error(path + " is damaged");
    Bytes bytes(head.bytes);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    model.emplace(or_throw(grid.tile_from_morton(head.key)), or_throw(decode_tile(bytes)));
  }
  return model;
}

}  // namespace

Model make_model(const ModelSource& source, const Grid& grid) {
  if (!source.cache.empty() && std::filesystem::exists(source.cache)) {
    return read_kept(source.cache, grid);
  }
  Model model = integrate(source, grid);
  if (!source.cache.empty()) keep(model, source.cache);
  return model;
}

std::vector<TileWeight> weigh(const Model& model) {
  std::vector<TileWeight> weights;
  for (const auto& [key, tree] : model) weights.push_back({key, tree.counts().occupied_voxels});
  return weights;
}

void write_file(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace voxatlas::bench
