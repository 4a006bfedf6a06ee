#pragma once

#include <cstdint>
#include <random>

namespace voxatlas::test {

/// The seed of this run: VOX_SEED from the environment, else a fixed one, so that CI repeats
/// itself.
std::uint64_t seed();

/// A fresh engine from seed(). Show the seed where it is used: `INFO("VOX_SEED=" << test::seed())`.
std::mt19937_64 engine();

}  // namespace voxatlas::test
