#pragma once

#include <cstdint>
#include <vector>

#include "sim/solid.hpp"
#include "sim/things.hpp"

namespace voxatlas {

/// The plan of a city: what stands where. All of it follows from the seed.

/// Houses, trees, lamps, signs, benches, and the cars that are parked for good.
std::vector<Solid> plan_still(std::uint64_t seed);

/// The vehicles on the roads at a time, seconds: lanes of them, each with one speed, from one end
/// of the city to the other; and parked cars that stay for a while, leave and come again.
std::vector<Vehicle> plan_traffic(std::uint64_t seed, double seconds);

}  // namespace voxatlas
