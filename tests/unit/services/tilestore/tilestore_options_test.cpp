#include <catch2/catch.hpp>

#include "tilestore/tilestore_process.hpp"

namespace voxatlas {
namespace {

TEST_CASE("options that are not given leave the stored model as it is", "[tilestore]") {
  ModelParameters stored;
  stored.cells_per_metre = 20;
  stored.integration.free_depth = 7;
  stored.shards = 2;
  REQUIRE(apply_options({}, 2, stored).value() == stored);
}

TEST_CASE("options that are given replace, and so can be told apart", "[tilestore]") {
  ModelOptions options;
  options.free_depth = 6;
  options.hit = 0.8;
  options.all_rays_free = true;
  const auto parameters = apply_options(options, 1, {});
  REQUIRE(parameters.has_value());
  REQUIRE(parameters->integration.free_depth == 6);
  REQUIRE(parameters->integration.all_rays_free);
  REQUIRE(parameters->sensor.hit == to_log_odds(0.8).value());
  REQUIRE(parameters->sensor.miss == ModelParameters{}.sensor.miss);
  REQUIRE_FALSE(describe_difference(ModelParameters{}, *parameters).empty());
}

TEST_CASE("options no model can have are refused, with the value", "[tilestore]") {
  ModelOptions options;
  SECTION("depth") { options.free_depth = 8; }
  SECTION("resolution") { options.cells_per_metre = 21; }
  SECTION("range") { options.max_range = -1; }
  SECTION("probability") { options.hit = 1.5; }
  SECTION("a hit that frees") { options.hit = 0.3; }
  REQUIRE(apply_options(options, 1, {}).error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
