#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "bus/wire.hpp"

namespace voxatlas {

/// The services heard of, each with its newest status; those silent for kSilence count as gone.
///
/// Time: steady microseconds.
class StatusBoard {
 public:
  static constexpr std::int64_t kSilence = 2'000'000;
  static constexpr std::size_t kMaxServices = 1000;  ///< More are not noted.

  void note(const status_t& status, std::int64_t now);
  /// How many services are ready and not silent.
  std::int64_t ready(std::int64_t now) const;

  /// On a terminal the whole table, drawn anew; elsewhere a line, or JSON, for `status` alone.
  void print(const status_t& status, bool json) const;

 private:
  struct Entry {
    status_t status;
    std::int64_t heard = 0;
  };
  std::string table(std::int64_t now) const;

  std::map<std::pair<std::string, std::int32_t>, Entry> services_;
};

}  // namespace voxatlas
