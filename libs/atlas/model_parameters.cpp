#include "atlas/model_parameters.hpp"

#include <fmt/format.h>

#include "base/check.hpp"
#include "base/sha256.hpp"

namespace voxatlas {

/// First byte of the encoding: 1 has no all_rays_free, every ray does. What it can tell is still
/// written with it, so that older programs read it and parameters_id() stays.
static constexpr std::uint8_t kVersion = 2;

Status ModelParameters::check() const {
  if (auto made = Grid::create(cells_per_metre); !made) return pass_on(made);
  if (!sensor.valid()) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("sensor model hit {}, miss {}, clamps {} and {} (log-odds in 1/4096) "
                            "contradicts itself",
                            sensor.hit, sensor.miss, sensor.clamp_min, sensor.clamp_max));
  }
  if (auto ok = integration.check(); !ok) return ok;
  if (shards < 1) return fail(ErrorCode::kOutOfRange, "shards 0: a model has at least one");
  return {};
}

Grid ModelParameters::grid() const {
  auto made = Grid::create(cells_per_metre);
  VOX_CHECK(made.has_value());
  return *made;
}

Bytes encode_parameters(const ModelParameters& parameters) {
  Bytes bytes;
  ByteWriter out(bytes);
  const bool all_rays_free = parameters.integration.all_rays_free;
  out.put(all_rays_free ? std::uint8_t{1} : kVersion);
  out.put(static_cast<std::int32_t>(parameters.cells_per_metre));
  out.put(parameters.sensor.hit);
  out.put(parameters.sensor.miss);
  out.put(parameters.sensor.clamp_min);
  out.put(parameters.sensor.clamp_max);
  out.put(static_cast<std::int32_t>(parameters.integration.free_depth));
  out.put(static_cast<std::int32_t>(parameters.integration.surface_depth));
  out.put(parameters.integration.min_range);
  out.put(parameters.integration.max_range);
  out.put(parameters.shards);
  if (!all_rays_free) out.put(std::uint8_t{0});
  return bytes;
}

Result<ModelParameters> decode_parameters(ByteView bytes) {
  ByteReader in(bytes);
  const auto version = in.get<std::uint8_t>();
  if (in.ok() && version > kVersion) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("model parameters of version {}: this program knows {}", version, kVersion));
  }
  ModelParameters parameters;
  parameters.cells_per_metre = in.get<std::int32_t>();
  parameters.sensor.hit = in.get<LogOdds>();
  parameters.sensor.miss = in.get<LogOdds>();
  parameters.sensor.clamp_min = in.get<LogOdds>();
  parameters.sensor.clamp_max = in.get<LogOdds>();
  parameters.integration.free_depth = in.get<std::int32_t>();
  parameters.integration.surface_depth = in.get<std::int32_t>();
  parameters.integration.min_range = in.get<double>();
  parameters.integration.max_range = in.get<double>();
  parameters.shards = in.get<std::uint32_t>();
  const auto all_rays_free = version < 2 ? std::uint8_t{1} : in.get<std::uint8_t>();
  parameters.integration.all_rays_free = all_rays_free == 1;
  if (!in.at_end() || version == 0 || all_rays_free > 1) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("model parameters: {} bytes do not parse", bytes.size()));
  }
  if (auto ok = parameters.check(); !ok) {
    return fail(ErrorCode::kCorrupt, "model parameters: " + ok.error().message);
  }
  return parameters;
}

std::int64_t parameters_id(const ModelParameters& parameters) {
  const auto digest = sha256(encode_parameters(parameters));
  std::uint64_t id = 0;
  std::memcpy(&id, digest.data(), sizeof id);
  return static_cast<std::int64_t>(id >> 1);
}

std::string describe_difference(const ModelParameters& have, const ModelParameters& want) {
  std::string text;
  const auto compare = [&text](const char* name, auto a, auto b) {
    if (a == b) return;
    text += fmt::format("{}{} {}, not {}", text.empty() ? "" : "; ", name, a, b);
  };
  const auto compare_log_odds = [&text](const char* name, LogOdds a, LogOdds b) {
    if (a == b) return;
    text += fmt::format("{}{} {:.4f} (log-odds {}/4096), not {:.4f} ({}/4096)",
                        text.empty() ? "" : "; ", name, to_probability(a), a, to_probability(b), b);
  };
  compare("cells_per_metre", have.cells_per_metre, want.cells_per_metre);
  compare_log_odds("hit", have.sensor.hit, want.sensor.hit);
  compare_log_odds("miss", have.sensor.miss, want.sensor.miss);
  compare_log_odds("clamp_min", have.sensor.clamp_min, want.sensor.clamp_min);
  compare_log_odds("clamp_max", have.sensor.clamp_max, want.sensor.clamp_max);
  compare("free_depth", have.integration.free_depth, want.integration.free_depth);
  compare("surface_depth", have.integration.surface_depth, want.integration.surface_depth);
  compare("min_range", have.integration.min_range, want.integration.min_range);
  compare("max_range", have.integration.max_range, want.integration.max_range);
  compare("all_rays_free", have.integration.all_rays_free, want.integration.all_rays_free);
  compare("shards", have.shards, want.shards);
  return text;
}

}  // namespace voxatlas
