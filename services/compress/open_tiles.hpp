#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <vector>

namespace voxatlas {

/// The raw tiles that have come and whose results the store has not yet: they stay uncommitted, so
/// that a compressor that is killed gets them again.
///
/// Order: a stream's tiles come from one shard, and their results go back to it in the same order.
/// Threads: one at a time.
class OpenTiles {
 public:
  struct Raw {
    std::int64_t session = 0, number = 0;  ///< The message that brought the tile.
  };
  struct Result {
    std::size_t shard = 0;
    std::int64_t number = 0;  ///< In the stream to that shard.
  };

  void answered(const Raw& raw, const Result& result) {
    open_[raw.session].push_back({raw.number, result});
  }
  void dropped(const Raw& raw) { open_[raw.session].push_back({raw.number, std::nullopt}); }

  /// What can be committed: of each stream the last message up to which all results are
  /// `committed(shard)`, the number below which the shard has committed.
  std::vector<Raw> take_done(const std::function<std::int64_t(std::size_t)>& committed);

  std::size_t size() const;

 private:
  struct Open {
    std::int64_t number = 0;
    std::optional<Result> result;  ///< None: the tile was dropped.
  };
  std::map<std::int64_t, std::deque<Open>> open_;  // By session.
};

}  // namespace voxatlas
