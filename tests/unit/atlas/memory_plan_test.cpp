#include "atlas/memory_plan.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TEST_CASE("the parts of a memory budget fit into it, and grow with it", "[atlas]") {
  MemoryPlan before;
  for (std::size_t budget = MemoryPlan::kLeastBudget; budget < std::size_t{1} << 42; budget *= 3) {
    const auto plan = MemoryPlan::of(budget).value();
    REQUIRE(plan.tiles + plan.store + plan.arriving + 12 * plan.commit <= budget);
    REQUIRE(plan.write_buffers < plan.store);
    REQUIRE(plan.tiles > before.tiles);
    REQUIRE(plan.write_buffers > before.write_buffers);
    REQUIRE(plan.arriving > before.arriving);
    REQUIRE(plan.commit > before.commit);
    before = plan;
  }
}

TEST_CASE("a memory budget that cannot be kept is refused with both numbers", "[atlas]") {
  const auto refused = MemoryPlan::of(MemoryPlan::kLeastBudget - 1);
  REQUIRE(refused.error().code == ErrorCode::kOutOfRange);
  REQUIRE(refused.error().message.find("128 MiB") != std::string::npos);
  REQUIRE(MemoryPlan::of(MemoryPlan::kLeastBudget).has_value());
}

}  // namespace
}  // namespace voxatlas
