#include "render/build_job.hpp"

#include <fmt/format.h>

#include <utility>

#include "codec/tile_codec.hpp"

namespace voxatlas {
namespace {

Result<TileTree> tile_of(BuildJob& job) {
  if (job.tile) return std::move(*job.tile);
  const bool whole = job.depth == kDepth || !job.changes.empty() || job.keep || job.free_depth > 0;
  return whole ? decode_tile(*job.bytes) : decode_tile_to_depth(*job.bytes, job.depth);
}

Status apply(const std::vector<Bytes>& changes, TileTree& tile, const SensorModel& sensor) {
  for (const Bytes& bytes : changes) {
    auto delta = decode_delta(bytes);
    if (!delta) return pass_on(delta);
    tile.apply(*delta, sensor);
  }
  return {};
}

}  // namespace

BuiltTile build(BuildJob job, const SensorModel& sensor) {
  BuiltTile built{job.key, job.version, job.depth, nullptr, nullptr, {}, 0, {}, false, false};
  if (job.middle) {
    TreesAround around(*job.middle);
    for (const auto& [offset, tree] : job.around) around.set(offset, tree.get());
    built.tree = std::make_shared<const RenderTree>(job.middle->with_borders(around));
    built.borders = true;
    return built;
  }
  const auto refuse = [&](auto& failed) {
    built.sound = pass_on(failed, fmt::format("tile {:#x}", job.key.morton()));
    return std::move(built);
  };
  auto tile = tile_of(job);
  built.no_tile = !tile;
  if (!tile) return refuse(tile);
  if (auto applied = apply(job.changes, *tile, sensor); !applied) return refuse(applied);
  built.tree = std::make_shared<const RenderTree>(*tile, job.version, job.depth, job.before.get());
  if (job.free_depth > 0) built.free = std::make_shared<const FreeCells>(*tile, job.free_depth);
  if (job.keep) {
    built.tile_bytes = tile->memory_bytes();
    built.tile = std::move(*tile);
  }
  return built;
}

}  // namespace voxatlas
