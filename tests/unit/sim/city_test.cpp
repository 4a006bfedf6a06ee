#include "sim/city.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "random_solids.hpp"
#include "sim/ground.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("what a beam meets in the city is the first of all its surfaces", "[sim][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto city = City::create({});
  REQUIRE(city.has_value());
  const Instant now(*city, 17);
  int surfaces = 0;
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d from(test::between(rng, -200, 200), 75 * test::between(rng, -0.09, 0.09),
                         test::between(rng, 1, 3));
    from.z() += Ground::height(from.x(), from.y());
    const Beam beam(from, test::unit_vector(rng));
    double nearest = Ground::first_hit(beam, 120).t;
    for (const auto* grid : {&city->still(), &now.moving()}) {
      for (const Solid& solid : grid->solids()) nearest = std::min(nearest, entry(solid, beam));
    }
    const auto sight = now.look(beam, 120);
    CAPTURE(i);
    REQUIRE(sight.t == (nearest < 120 ? nearest : kNoHit));
    if (sight.t == kNoHit || sight.t == 0) continue;
    ++surfaces;
    REQUIRE(std::abs(now.nearest(beam.at(sight.t), 0.5).distance) < 1e-6);
  }
  REQUIRE(surfaces > 500);
}

TEST_CASE("the city has all that a street has", "[sim]") {
  const auto city = City::create({});
  std::map<Material, int> bodies;
  for (const Solid& solid : city->still().solids()) {
    ++bodies[solid.material];
    REQUIRE((solid.min.array() < solid.max.array()).all());
  }
  for (const auto material :
       {Material::kWall, Material::kGlass, Material::kDoor, Material::kRoof, Material::kTrunk,
        Material::kLeaves, Material::kPole, Material::kCarBody, Material::kTyre}) {
    CAPTURE(static_cast<int>(material));
    REQUIRE(bodies[material] > 100);
  }
}

TEST_CASE("windows lie 20 cm deep in facades", "[sim]") {
  const auto city = City::create({});
  const Instant now(*city, 0);
  // A sweep along a facade, straight on: from the street between blocks 3,2 and 3,3.
  std::map<Material, double> depth;
  for (double x = -60; x < -15; x += 0.05) {
    const auto sight = now.look(Beam({x, -75, Ground::plane(x, -75) + 7.5}, {0, 1, 0}), 60);
    if (sight.material == Material::kWall || sight.material == Material::kGlass) {
      auto [entry, fresh] = depth.try_emplace(sight.material, sight.t);
      if (!fresh) entry->second = std::min(entry->second, sight.t);
    }
  }
  REQUIRE(depth.size() == 2);
  REQUIRE(depth[Material::kGlass] - depth[Material::kWall] == Approx(kWindowDepth).margin(1e-9));
}

TEST_CASE("vehicles move at their lane's speed and what stands stays", "[sim]") {
  const auto city = City::create({});
  const Instant now(*city, 100), later(*city, 100.5);
  int moved = 0, stood = 0;
  for (const Vehicle& before : now.vehicles()) {
    for (const Vehicle& after : later.vehicles()) {
      const Eigen::Vector2d gone = after.centre - before.centre;
      if (gone.norm() == 0) ++stood;
      if (gone[1 - before.axis] == 0 && after.axis == before.axis &&
          std::abs(gone[before.axis]) > 2.99 && std::abs(gone[before.axis]) < 6.01) {
        ++moved;  // 6 to 12 m/s for half a second, along its lane.
      }
    }
  }
  REQUIRE(moved > 80);
  REQUIRE(stood > 20);
}

TEST_CASE("a vehicle's place is solid while it is there and free when it has gone", "[sim]") {
  const auto city = City::create({});
  const Instant now(*city, 50), later(*city, 53);
  int cleared = 0;
  for (const Vehicle& vehicle : now.vehicles()) {
    const double z = Ground::height(vehicle.centre.x(), vehicle.centre.y()) + 0.6;
    const Eigen::Vector3d p(vehicle.centre.x(), vehicle.centre.y(), z);
    REQUIRE(now.nearest(p, 1).distance < 0);
    REQUIRE(now.nearest(p, 1).moves);
    cleared += later.nearest(p, 0.3).distance > 0.2;
  }
  REQUIRE(cleared > 80);
}

TEST_CASE("cities of one seed are the same and of another differ", "[sim]") {
  const auto a = City::create({}), b = City::create({}), c = City::create({2, {}, 0});
  const auto same = [](const City& x, const City& y) {
    const auto p = x.still().solids(), q = y.still().solids();
    return std::equal(p.begin(), p.end(), q.begin(), q.end(), [](const auto& s, const auto& t) {
      return s.min == t.min && s.max == t.max && s.colour == t.colour && s.shape == t.shape;
    });
  };
  REQUIRE(same(*a, *b));
  REQUIRE_FALSE(same(*a, *c));
}

TEST_CASE("a city stands anywhere on the Earth, and nowhere else", "[sim]") {
  REQUIRE(City::create({1, {-89.999, 180, 2800}, 0}).has_value());
  const auto off = City::create({1, {48, 11, 1e9}, 0});
  REQUIRE_FALSE(off.has_value());
  REQUIRE(off.error().code == ErrorCode::kOutOfRange);
}

}  // namespace
}  // namespace voxatlas
