#include "render/pacer.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace voxatlas {
namespace {

constexpr std::int64_t kPixels = 1280 * 720;

/// A machine by simple arithmetic: a part for the tiles, the rest by pixels and rays.
double takes(const PaceStep& step, double scene_ms) {
  const double part = step.pixel_threshold > 0 ? 0.8 : 1;
  return scene_ms * part * step.samples * step.samples / (step.shrink * step.shrink);
}

std::vector<PaceStep> draw_view(Pacer& pacer, const Pace& pace, double scene_ms) {
  REQUIRE(pacer.begin(pace).has_value());
  std::vector<PaceStep> steps;
  while (const auto step = pacer.next()) {
    pacer.measured(*step, takes(*step, scene_ms));
    steps.push_back(*step);
    REQUIRE(steps.size() <= Pacer::kRungs);
  }
  return steps;
}

TEST_CASE("first pictures come within the budget once the scene is known", "[pacer]") {
  for (const double budget : {3.0, 10.0, 25.0, 40.0, 100.0}) {
    Pacer pacer;
    const Pace pace{budget, kDepth, kPixels, true};
    for (int i = 0; i < 10; ++i) draw_view(pacer, pace, 30);
    const auto first = draw_view(pacer, pace, 30).front();
    CAPTURE(budget, first.rung);
    REQUIRE(takes(first, 30) <= budget);
    if (budget >= 100) REQUIRE(first.rung == Pacer::kFull);
    if (budget >= 10) REQUIRE(first.rung > 0);
  }
}

TEST_CASE("a resting camera is refined to the full and then the supersampled picture", "[pacer]") {
  for (const bool supersample : {true, false}) {
    Pacer pacer;
    std::int64_t sequence = 0;
    for (const double scene_ms : {30.0, 300.0, 5.0}) {
      const auto steps = draw_view(pacer, {20, 6, kPixels, supersample}, scene_ms);
      for (const auto& step : steps) {
        REQUIRE(step.sequence == ++sequence);
        REQUIRE(step.final == (&step == &steps.back()));
        REQUIRE(step.in_budget == (&step == &steps.front()));
      }
      const PaceStep& full = supersample ? steps[steps.size() - 2] : steps.back();
      REQUIRE((full.depth == 6 && full.pixel_threshold == 0));
      REQUIRE((full.shrink == 1 && full.samples == 1));
      if (supersample) REQUIRE(steps.back().samples == 4);
    }
  }
}

TEST_CASE("pictures over budget are counted, abandoned ones are not", "[pacer]") {
  Pacer pacer;
  for (int i = 0; i < 7; ++i) {
    REQUIRE(pacer.begin({10, kDepth, kPixels, true}).has_value());
    const auto first = pacer.next();
    if (i == 3) continue;
    pacer.measured(*first, i % 2 == 0 ? 10.0 : 10.1);
    pacer.measured(*pacer.next(), 1000);  // A refinement has no budget.
  }
  REQUIRE(pacer.budgeted() == 6);
  REQUIRE(pacer.over_budget() == 2);
}

TEST_CASE("without a budget the first picture is the full one", "[pacer]") {
  Pacer pacer;
  const auto steps = draw_view(pacer, {0, 5, kPixels, false}, 500);
  REQUIRE(steps.size() == 1);
  REQUIRE((steps[0].final && !steps[0].in_budget && steps[0].rung == Pacer::kFull));
}

TEST_CASE("the pacer refuses what is no pace and survives times that are none", "[pacer]") {
  Pacer pacer;
  REQUIRE_FALSE(pacer.next().has_value());
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const double budget : {-1.0, nan, infinity, 1e9}) {
    REQUIRE_FALSE(pacer.begin({budget, 7, 1, true}).has_value());
  }
  for (const int depth : {-1, 8}) REQUIRE_FALSE(pacer.begin({1, depth, 1, true}).has_value());
  REQUIRE_FALSE(pacer.begin({1, 7, 0, true}).has_value());
  for (const double ms : {nan, infinity, -5.0, 0.0, 1e300}) {
    REQUIRE(pacer.begin({10, 7, kPixels, true}).has_value());
    pacer.measured(*pacer.next(), ms);
    REQUIRE(std::isfinite(pacer.predicted_ms(Pacer::kFull, kPixels)));
  }
}

}  // namespace
}  // namespace voxatlas
