#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "atlas/atlas.hpp"
#include "atlas/model_parameters.hpp"
#include "base/result.hpp"
#include "bus/bus_url.hpp"

namespace voxatlas {

/// What a person may say of a model; what is not said is the stored model's, or the default.
struct ModelOptions {
  std::optional<int> cells_per_metre, free_depth, surface_depth;
  std::optional<bool> all_rays_free;
  std::optional<double> min_range, max_range;
  std::optional<double> hit, miss, clamp_min, clamp_max;  ///< Probabilities.
};

struct TilestoreOptions {
  std::string url = kDefaultBusUrl;
  std::string data_dir;  ///< Or a place in a cluster: StoreLocation::parse.
  std::int32_t shard = 0;
  std::int32_t shards = 1;
  std::int32_t compressors = 1;
  std::size_t memory_bytes = std::size_t{256} << 20;  ///< MemoryPlan's budget.
  std::size_t journal_max_bytes = AtlasOptions{}.journal_max_bytes;
  double rest_seconds = AtlasOptions{}.rest_seconds;
  std::size_t rest_bytes = AtlasOptions{}.rest_bytes;
  bool keep_journal = false;
  ModelOptions model;
};

/// The options over `base` (the stored model's parameters, or the defaults).
/// Errors: kOutOfRange for values no model can have.
Result<ModelParameters> apply_options(const ModelOptions& options, std::int32_t shards,
                                      const ModelParameters& base);

/// One life of the process: opens and recovers its shard, joins the bus, works until a signal,
/// flushes, closes. Sets `was_ready` once it works.
/// Errors: what keeps it from starting, or from going on.
Status serve_until_fault(const TilestoreOptions& options, bool& was_ready);

/// The process. Where the disk fails under its work (kIo, kUnknown) it says so on the bus and
/// begins anew every second, until the disk is well: nothing that was not acknowledged is forgotten
/// by its sender. Errors: what keeps it from starting, and any other.
Status serve_tilestore(const TilestoreOptions& options);

}  // namespace voxatlas
