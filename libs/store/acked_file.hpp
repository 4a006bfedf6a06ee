#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

/// The sequence number of the last write that was acknowledged, in a small file beside the
/// database, so that an opening can tell a log that lost its tail from one that ended there.
///
/// RocksDB takes a damaged last record of its log (or manifest) for one that a crash cut short, and
/// opens without it. The number here is written after each synced write, without syncing: a kill
/// keeps it, a power cut may leave an older one, never a newer one. So "the database is behind this
/// number" always means that acknowledged writes are gone.
///
/// Threads: raise() from any thread.
class AckedFile {
 public:
  AckedFile() = default;
  ~AckedFile();
  AckedFile(const AckedFile&) = delete;
  AckedFile& operator=(const AckedFile&) = delete;

  /// Opens or makes the file. Errors: kIo; kCorrupt where its checksum is wrong.
  Status open(const std::string& path);
  std::uint64_t sequence() const { return sequence_; }  ///< As read by open(); 0 for a new file.

  /// Writes a number if it is above the last one.
  Status raise(std::uint64_t sequence);
  /// The same, synced, for closing.
  Status sync();

 private:
  std::string path_;
  int file_ = -1;
  std::mutex mutex_;
  std::uint64_t sequence_ = 0;  // Guarded by mutex_ once raise() is in use.
};

}  // namespace voxatlas
