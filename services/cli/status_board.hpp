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

  /// All of them, a line each under a line of headings, each line cut to `width` characters.
  std::string table(std::int64_t now, std::size_t width) const;

 private:
  struct Entry {
    status_t status;
    std::int64_t heard = 0;
  };

  std::map<std::pair<std::string, std::int32_t>, Entry> services_;
};

/// One status as a line for a person, and as JSON with all its counters.
std::string status_line(const status_t& status);
std::string status_json(const status_t& status);

}  // namespace voxatlas
