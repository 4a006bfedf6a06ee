#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "octree/tile_delta.hpp"
#include "octree/tile_tree.hpp"

namespace voxatlas::test {

/// Random cells, states and deltas that meet often: most lie near a few places, and there are few
/// colours and log-odds to choose from, so that neighbours also become equal again.
class RandomOctree {
 public:
  explicit RandomOctree(std::uint64_t seed) : rng_(seed) {}

  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(rng_() % n); }
  const SensorModel& model() const { return model_; }

  CellKey cell() { return cell_at(static_cast<int>(below(8))); }

  CellKey cell_at(int depth) {
    // Places near the tile's corner, its middle and anywhere, in voxels as 21-bit Morton codes.
    const std::uint32_t place = below(3) == 0
                                    ? below(1u << 21)
                                    : (below(2) == 0 ? below(2048) : 0x1c0000 - 1024 + below(2048));
    return {static_cast<std::uint8_t>(depth), place >> 3 * (kDepth - depth)};
  }

  std::optional<Rgb> maybe_colour() {
    if (below(2) == 0) return std::nullopt;
    return colour();
  }

  Rgb colour() {
    return below(2) == 0 ? Rgb{200, 100, 50}
                         : Rgb{static_cast<std::uint8_t>(rng_()), static_cast<std::uint8_t>(rng_()),
                               static_cast<std::uint8_t>(rng_())};
  }

  CellState state() {
    CellState state{
        static_cast<LogOdds>(below(2) == 0 ? 1000 : static_cast<int>(below(65535)) - 32767), {}};
    if (state.log_odds >= 0 && below(2) == 0) {
      for (std::uint32_t i = below(20) + 1; i > 0; --i) state.colour.add(colour());
    }
    return state;
  }

  /// Keeps the rules of TileDelta: no miss meets a hit.
  TileDelta delta() {
    TileDelta delta;
    delta.misses.depth = static_cast<int>(below(8));
    delta.hits.depth = static_cast<int>(below(8));
    delta.coloured.depth = delta.hits.depth;
    fill(delta.hits, 1 + below(delta.hits.depth < 3 ? 2 : 200));
    const std::uint32_t wanted = below(4);
    delta.hits.for_each([&](CellKey cell) {
      if (wanted == 0 || (wanted == 1 && below(2) == 0)) delta.coloured.insert(cell);
    });
    for (std::uint64_t i = delta.coloured.size(); i > 0; --i) delta.colours.push_back(colour());
    CellSet misses = delta.misses;
    fill(misses, below(300));
    misses.for_each([&](CellKey miss) {
      bool meets = false;
      delta.hits.for_each(
          [&](CellKey hit) { meets = meets || hit.contains(miss) || miss.contains(hit); });
      if (!meets) delta.misses.insert(miss);
    });
    return delta;
  }

 private:
  void fill(CellSet& set, std::uint32_t cells) {
    for (; cells > 0; --cells) set.insert(cell_at(set.depth));
  }

  std::mt19937_64 rng_;
  SensorModel model_ = SensorModel::standard();
};

}  // namespace voxatlas::test
