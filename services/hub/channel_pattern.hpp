#pragma once

#include <bitset>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace voxatlas {

/// What an LCM client subscribes to: a regular expression that a channel's whole name must match.
///
/// Knows literals, `.`, `[a-z]`, `[^a-z]`, `( )`, `|`, `*`, `+`, `?` and `\` before any sign
/// that is neither letter nor digit.
/// Errors: kInvalid for anything else, naming the place.
/// Cost:   matching takes states times name's length steps at most, whatever the pattern: a client
///         cannot keep the hub busy with one (libraries that try and go back can take for ever).
class ChannelPattern {
 public:
  static constexpr std::size_t kMaxLength = 256;
  static constexpr int kMaxNesting = 64;

  static Result<ChannelPattern> parse(std::string_view text);
  bool matches(std::string_view name) const;

 private:
  friend class PatternParser;

  /// A step of the automaton: either a set of signs to read one of, or two ways to go on.
  struct Step {
    std::bitset<256> signs;
    bool reads = false;
    std::int32_t next = -1;   ///< kEnd or a step.
    std::int32_t other = -1;  ///< A second way, where nothing is read; -1: none.
  };
  static constexpr std::int32_t kEnd = -2;

  void reach(std::int32_t step, std::vector<bool>& reached) const;

  std::vector<Step> steps_;
  std::int32_t start_ = kEnd;
};

}  // namespace voxatlas
