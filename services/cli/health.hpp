#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/wire.hpp"

namespace voxatlas {

/// What `voxatlas doctor` has found out, before it judges.
struct HealthFacts {
  std::string url;
  bool is_multicast = true;
  std::optional<std::string> no_bus;  ///< Why it cannot be joined; empty: it can.
  bool echoed = false;                ///< 60 kB sent to it came back.
  std::size_t receive_buffer_bytes = 0;

  struct Heard {
    status_t status;         ///< The last of this instance.
    std::int64_t utime = 0;  ///< When it came, by our clock.
  };
  std::vector<Heard> services;  ///< One an instance.
  std::string version;          ///< Ours.

  std::string data_dir;
  enum class Folder { kMissing, kNoFolder, kReadOnly, kWritable };
  Folder folder = Folder::kMissing;
  std::vector<std::int32_t> shards;                   ///< That lie in it.
  std::uint64_t disk_free_bytes = 0, disk_bytes = 0;  ///< Where it lies, or would.

  std::int64_t utime = 0;
  std::optional<bool> clock_synchronised;  ///< By the kernel's word, where it gives it.
};

/// One thing that was looked at. kWrong: it does not work. kWeak: it works, and may not when it
/// matters.
struct Finding {
  enum class Level { kFine, kWeak, kWrong };
  Level level = Level::kFine;
  std::string check;  ///< "route", "multicast", "buffers", "hub", "services", "versions", "data
                      ///< folder", "disk", "clock".
  std::string what;   ///< In a sentence.
  std::string mend;   ///< What to do, in a sentence; empty where it is fine.
};

/// Judges. Every check gives at least one finding, in the order in which they should be mended.
std::vector<Finding> examine(const HealthFacts& facts);

}  // namespace voxatlas
