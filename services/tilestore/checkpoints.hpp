#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "bus/checkpoint_wire.hpp"
#include "store/tile_store.hpp"

namespace voxatlas {

/// Copies of a shard for those who ask, made in a thread of their own, one at a time: a copy is a
/// second's work, and no scan shall wait for it.
///
/// A copy is the state that a kill -9 would have left: every scan acknowledged so far is in it, in
/// tiles or in the journal, with its mark. Where the disk allows, its files are links.
/// Ownership: borrows the store. Who asked owns the copy, and removes it.
/// Threads: one at a time.
class Checkpoints {
 public:
  /// `data_dir`: the model's folder. A copy's is made in it.
  Checkpoints(TileStore& store, std::string data_dir);
  ~Checkpoints();  ///< Waits for the copy under way.

  /// Begins a copy for a question that is new; nullopt until it is made, or while another's is.
  std::optional<checkpoint_reply_t> answer(const checkpoint_request_t& request);

 private:
  static constexpr std::size_t kMostAnswers = 64;
  using Question = std::pair<std::int64_t, std::int64_t>;  ///< client, id

  bool is_busy() const;
  void begin(const checkpoint_request_t& request);

  TileStore& store_;
  std::string data_dir_;
  Question question_;                   ///< The newest.
  std::future<Status> copying_;         ///< For it; valid while its outcome was not taken.
  std::map<Question, Status> answers_;  ///< Of all, to be told again; kMostAnswers at most.
};

}  // namespace voxatlas
