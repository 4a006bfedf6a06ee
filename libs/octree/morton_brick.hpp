#pragma once

#include <array>
#include <optional>

#include "octree/brick_table.hpp"

namespace voxatlas {

/// A cell's summary while it is being made: the highest log-odds and the sum of the colours.
class Summary {
 public:
  void add(const CellState& state, std::uint64_t voxels = 1);
  void add(const Brick& brick, const BrickColours* colours);
  /// nullopt where nothing was added. The mean colour is rounded to nearest.
  std::optional<CellState> state() const;

 private:
  void add(LogOdds log_odds, std::uint64_t voxels);
  void add(const Colour& colour, std::uint64_t voxels);

  std::uint64_t voxels_ = 0, coloured_ = 0;
  std::array<std::uint64_t, 3> sum_{};
  std::uint16_t count_ = 0;
  LogOdds highest_ = 0;
};

/// A mixed brick with its voxels in Morton order, in which every cell of it is a run: what
/// encoding, summing and walking in the octree's order want.
class MortonBrick {
 public:
  MortonBrick(const BrickTable& table, unsigned brick);

  /// A run of 1, 8, 64 or 512 voxels that starts at a multiple of its length.
  bool is_empty(unsigned first, unsigned count) const;
  std::optional<CellState> uniform(unsigned first, unsigned count) const;
  void add_to(Summary& summary, unsigned first, unsigned count) const;
  CellState state(unsigned at) const;  ///< A known voxel's.
  bool is_known(unsigned at) const { return (known_[at / 8] >> at % 8 & 1) != 0; }

 private:
  std::array<LogOdds, kBrickVoxels> log_odds_;
  std::array<std::uint8_t, kBrickVoxels / 8> known_;
  bool coloured_;
  std::array<Colour, kBrickVoxels> colours_;  ///< Only where coloured_; else not initialised.
};

}  // namespace voxatlas
