// One binary, many processors: whichever instructions Highway picks, a scan changes the same bytes.
#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <map>

#include "integrate/integrator.hpp"
#include "octree/tile_hash.hpp"
#include "octree/tile_tree.hpp"
#include "support/engine.hpp"
#include "unit/integrate/scan_oracle.hpp"
#include "unit/integrate/test_scans.hpp"

namespace voxatlas {
namespace {

/// All that scans lead to: the deltas' bytes in their order, and the tiles' hashes.
struct Outcome {
  Bytes deltas;
  std::map<TileKey, std::string> tiles;

  friend bool operator==(const Outcome&, const Outcome&) = default;
};

Outcome import_with(std::int64_t target, const std::vector<Scan>& scans,
                    const IntegrationParameters& parameters) {
  hwy::SetSupportedTargetsForTest(target);
  Outcome outcome;
  std::map<TileKey, TileTree> tiles;
  Integrator integrator(Grid::standard(), parameters);
  for (const auto& scan : scans) {
    const auto delta = integrator.integrate(scan);
    REQUIRE(delta.has_value());
    for (const auto& [key, change] : delta->tiles) {
      encode_delta(change, outcome.deltas);
      tiles[key].apply(change, SensorModel::standard());
    }
  }
  for (const auto& [key, tile] : tiles) outcome.tiles[key] = to_hex(tile_hash(key, tile));
  hwy::SetSupportedTargetsForTest(0);
  return outcome;
}

void require_same_on_all(const std::vector<Scan>& scans, const IntegrationParameters& parameters) {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  // The last is the plainest, which carves by Walk alone.
  const auto plain = import_with(targets.back(), scans, parameters);
  REQUIRE_FALSE(plain.deltas.empty());
  for (const auto target : targets) {
    CAPTURE(hwy::TargetName(target), parameters.free_depth, parameters.surface_depth);
    REQUIRE((import_with(target, scans, parameters) == plain));
  }
}

TEST_CASE("a street's scans change the same bytes with every set of instructions",
          "[integrate][oracle]") {
  const auto parameters =
      GENERATE(IntegrationParameters{7, 7, 0, 120}, IntegrationParameters{4, 7, 0, 120, true},
               IntegrationParameters{4, 7, 0, 120}, IntegrationParameters{-1, 7, 0, 120},
               IntegrationParameters{5, 6, 0, 120});
  require_same_on_all(test::street_scans(2), parameters);
}

TEST_CASE("a real scan changes the same bytes with every set of instructions",
          "[integrate][oracle]") {
  const auto scans = test::real_scans(1);
  if (scans.empty()) {
    WARN("skipped: no real scans in " << test::data_folder() << " (VOX_DATA)");
    return;
  }
  require_same_on_all(scans, {7, 7, 0, 120});
}

TEST_CASE("coloured rays on borders change the same bytes with every set of instructions",
          "[integrate][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const int free_depth = GENERATE(range(-1, 8));
  std::vector<Scan> scans;
  for (int i = 0; i < 10; ++i) {
    scans.push_back(test::ScanMaker{{4147200, 614400, -4736000}, 40, 10, 60, i % 2 == 0}(rng));
    scans.back().sigma = 0.02;
  }
  require_same_on_all(scans, {free_depth, 7, 0, 60});
}

}  // namespace
}  // namespace voxatlas
