#include "grid/region_key.hpp"

#include "base/check.hpp"

namespace voxatlas {

std::uint32_t shard_of(RegionKey region, std::uint32_t shards) {
  VOX_CHECK(shards >= 1);
  return static_cast<std::uint32_t>(splitmix64(region.code) % shards);
}

std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

}  // namespace voxatlas
