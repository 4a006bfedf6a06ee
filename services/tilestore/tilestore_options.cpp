// What a person says of a model, over what the model says of itself.
#include "tilestore/tilestore_process.hpp"

namespace voxatlas {

Result<ModelParameters> apply_options(const ModelOptions& options, std::int32_t shards,
                                      const ModelParameters& base) {
  ModelParameters result = base;
  result.cells_per_metre = options.cells_per_metre.value_or(base.cells_per_metre);
  auto& integration = result.integration;
  integration.free_depth = options.free_depth.value_or(integration.free_depth);
  integration.surface_depth = options.surface_depth.value_or(integration.surface_depth);
  integration.all_rays_free = options.all_rays_free.value_or(integration.all_rays_free);
  integration.min_range = options.min_range.value_or(integration.min_range);
  integration.max_range = options.max_range.value_or(integration.max_range);
  const auto set = [](const std::optional<double>& probability, LogOdds& value) -> Status {
    if (!probability) return {};
    auto log_odds = to_log_odds(*probability);
    if (!log_odds) return pass_on(log_odds);
    value = *log_odds;
    return {};
  };
  for (auto& status : {set(options.hit, result.sensor.hit), set(options.miss, result.sensor.miss),
                       set(options.clamp_min, result.sensor.clamp_min),
                       set(options.clamp_max, result.sensor.clamp_max)}) {
    if (!status) return tl::unexpected<Error>(status.error());
  }
  result.shards = static_cast<std::uint32_t>(shards);
  if (auto sound = result.check(); !sound) return pass_on(sound);
  return result;
}

}  // namespace voxatlas
