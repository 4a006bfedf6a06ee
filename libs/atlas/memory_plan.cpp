#include "atlas/memory_plan.hpp"

#include <fmt/format.h>

namespace voxatlas {

/// A delta on its way into the journal is held as it came, decoded, as a record, with the record's
/// checksum, in RocksDB's batch, as a change and as an update.
static constexpr std::size_t kFormsOfADelta = 12;

Result<MemoryPlan> MemoryPlan::of(std::size_t budget) {
  if (budget < kLeastBudget) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a memory budget of {:.4g} MiB: a tile store needs at least {} MiB",
                            static_cast<double>(budget) / (1 << 20), kLeastBudget >> 20));
  }
  MemoryPlan plan;
  plan.tiles = budget * 5 / 8;
  plan.store = budget / 8;
  plan.write_buffers = plan.store / 2;
  plan.arriving = budget / 16;
  plan.commit = budget / 8 / kFormsOfADelta;
  return plan;
}

}  // namespace voxatlas
