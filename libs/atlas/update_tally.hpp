#pragma once

#include <cstdint>
#include <optional>

namespace voxatlas {

/// Whether a subscriber has heard all of a shard's updates, by the count the store states in its
/// status: a lost update of a tile that never changes again shows in no version.
///
/// Source:  DESIGN section 6, late joiner.
/// Order:   updates and statuses of a store must come in the order they were sent, as they do by
///          one connection of the bus; any may be lost.
/// Quiet:   while updates come, those that were lost mostly show as gaps of versions, and listing
///          would burden the store: a difference counts once nothing came for kQuietUs.
/// Time:    microseconds of one steady clock, given with each call.
/// Threads: one at a time.
class UpdateTally {
 public:
  static constexpr std::int64_t kQuietUs = 200'000;

  /// An update of the shard has come.
  void on_update(std::int64_t now);
  /// The store's word: which run of it this is, and how many updates that run has published.
  void on_status(std::int64_t instance, std::uint64_t published, std::int64_t now);

  /// Whether the shard's tiles must be listed: it is new, or some updates were lost. Listing takes
  /// a while, in which updates and statuses go on, and may fail: then it must be done again.
  bool must_list() const { return must_list_; }
  void begin_list();
  void end_list(bool done);

  /// Whether every update that the last status counted is heard or made good by a list.
  bool is_complete() const { return instance_ && !must_list_ && !is_listing_ && heard_ == told_; }
  std::int64_t last_update() const { return last_update_; }  ///< 0: none yet.

 private:
  std::optional<std::int64_t> instance_;
  std::uint64_t heard_ = 0;  ///< Updates, those before the last list counted as heard.
  std::uint64_t told_ = 0;   ///< By the last status.
  std::int64_t last_update_ = 0;
  bool must_list_ = false;
  bool is_listing_ = false;
};

}  // namespace voxatlas
