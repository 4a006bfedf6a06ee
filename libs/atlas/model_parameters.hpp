#pragma once

#include <cstdint>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/grid.hpp"
#include "integrate/integrator.hpp"
#include "octree/log_odds.hpp"

namespace voxatlas {

/// What a model is made with, fixed when it is made and stored in it. Every service of a set works
/// with the same; one that is told others refuses to start.
struct ModelParameters {
  int cells_per_metre = 10;
  SensorModel sensor = SensorModel::standard();
  IntegrationParameters integration;
  std::uint32_t shards = 1;

  Status check() const;  ///< kOutOfRange, naming the value that cannot be.
  Grid grid() const;     ///< check() must hold.

  friend bool operator==(const ModelParameters&, const ModelParameters&) = default;
};

Bytes encode_parameters(const ModelParameters& parameters);
Result<ModelParameters> decode_parameters(ByteView bytes);

/// 63 bits that differ where parameters differ: deltas carry it, and a store refuses others'.
std::int64_t parameters_id(const ModelParameters& parameters);

/// In words, which values differ: "free_depth 4, not 7"; empty where none does.
std::string describe_difference(const ModelParameters& have, const ModelParameters& want);

}  // namespace voxatlas
