#include "support/engine.hpp"

#include <cstdlib>

namespace voxatlas::test {

std::uint64_t seed() {
  const char* text = std::getenv("VOX_SEED");
  return text == nullptr ? 20261122 : std::strtoull(text, nullptr, 0);
}

std::mt19937_64 engine() { return std::mt19937_64(seed()); }

}  // namespace voxatlas::test
