#pragma once

#include <cstddef>
#include <deque>
#include <utility>

#include "store/tile_store.hpp"

namespace voxatlas {

/// The records a journal still holds: where, and how large. Not what is in them.
class JournalTail {
 public:
  /// Counts a little for a record beside its bytes, so that many small ones are bounded too, and
  /// with them what stands here.
  static constexpr std::size_t kRecordOverhead = 256;

  void append(JournalPosition position, std::size_t bytes) {
    records_.emplace_back(position, bytes + kRecordOverhead);
    bytes_ += records_.back().second;
    last_ = position;
  }

  void trim(JournalPosition position) {
    while (!records_.empty() && records_.front().first <= position) {
      bytes_ -= records_.front().second;
      records_.pop_front();
    }
  }

  /// True where records up to this position are still held.
  bool holds(JournalPosition position) const {
    return !records_.empty() && records_.front().first <= position;
  }

  std::size_t records() const { return records_.size(); }
  std::size_t bytes() const { return bytes_; }
  JournalPosition last() const { return last_; }  ///< 0 where none was ever seen.

 private:
  std::deque<std::pair<JournalPosition, std::size_t>> records_;
  std::size_t bytes_ = 0;
  JournalPosition last_ = 0;
};

}  // namespace voxatlas
