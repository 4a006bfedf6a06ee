#include "octree/log_odds.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace voxatlas {
namespace {

TEST_CASE("every log-odds of the lattice survives the way through its probability", "[octree]") {
  for (int steps = -32767; steps <= 32767; ++steps) {
    const auto log_odds = static_cast<LogOdds>(steps);
    REQUIRE(to_float_log_odds(log_odds) == steps / 4096.0);
    REQUIRE(to_log_odds(to_probability(log_odds)) == log_odds);
    REQUIRE(is_occupied(log_odds) == (to_probability(log_odds) >= 0.5));
  }
}

TEST_CASE("what is no log-odds below 8 is refused, with its value", "[octree]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double bad = GENERATE_COPY(0.0, 1.0, -0.1, 1.1, nan, 0.9997, 0.0003, 1e-300);
  const auto log_odds = to_log_odds(bad);
  REQUIRE_FALSE(log_odds.has_value());
  REQUIRE(log_odds.error().code == ErrorCode::kOutOfRange);
  REQUIRE(to_log_odds(0.9996).has_value());
  REQUIRE(to_log_odds(0.0004).has_value());
}

TEST_CASE("the standard sensor model is OctoMap's, on the lattice", "[octree]") {
  const SensorModel model = SensorModel::standard();
  REQUIRE(model == SensorModel{3471, -1661, -8161, 14238});
  REQUIRE(std::abs(to_probability(model.hit) - 0.7) < 1e-4);
  REQUIRE(std::abs(to_probability(model.miss) - 0.4) < 1e-4);
}

TEST_CASE("a sensor model that contradicts itself is refused by name", "[octree]") {
  const auto refused = [](double hit, double miss, double low, double high, const char* name) {
    const auto model = SensorModel::from_probabilities(hit, miss, low, high);
    REQUIRE_FALSE(model.has_value());
    REQUIRE(model.error().code == ErrorCode::kOutOfRange);
    REQUIRE_THAT(model.error().message, Catch::Contains(name));
  };
  refused(1, 0.4, 0.12, 0.97, "hit");
  refused(0.7, 0, 0.12, 0.97, "miss");
  refused(0.7, 0.4, 0.0001, 0.97, "clamp_min");
  refused(0.7, 0.4, 0.12, std::nan(""), "clamp_max");
  refused(0.5, 0.4, 0.12, 0.97, "hit 0.5");
  refused(0.50001, 0.4, 0.12, 0.97, "hit");  // A step of the lattice is more than that.
  refused(0.7, 0.5, 0.12, 0.97, "miss 0.5");
  refused(0.7, 0.4, 0.5, 0.97, "clamp_min 0.5");
  refused(0.7, 0.4, 0.12, 0.4, "clamp_max 0.4");
  REQUIRE(SensorModel::from_probabilities(0.7, 0.4, 0.12, 0.5).has_value());
}

TEST_CASE("an update is the clamped sum", "[octree]") {
  const SensorModel model{32767, -32767, -32767, 32767};
  REQUIRE(model.update(32767, model.hit) == 32767);
  REQUIRE(model.update(-32767, model.miss) == -32767);
  REQUIRE(model.update(5, model.miss) == -32762);
  const SensorModel narrow{100, -100, -50, 70};
  REQUIRE(narrow.update(0, narrow.hit) == 70);
  REQUIRE(narrow.update(0, narrow.miss) == -50);
  REQUIRE(narrow.update(32767, narrow.miss) == 70);
}

}  // namespace
}  // namespace voxatlas
