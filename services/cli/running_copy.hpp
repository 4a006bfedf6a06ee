#pragma once

#include <optional>
#include <string>

#include "base/result.hpp"
#include "cli/model_folder.hpp"

namespace voxatlas {

/// Moves a folder; where it must go to another file system it is copied. `to` must not exist.
Status move_folder(const std::string& from, const std::string& to);

/// Asks the services that run on `data_dir` for a copy of their model, each of its shard, and puts
/// it into `folder`, which is made. Each shard is as a kill -9 would have left it then; the shards
/// need not have applied the same scans, as after a kill.
///
/// Errors: kUnavailable where nobody answers at `url`, kInvalid where the set there works on
///         another folder; kIo.
Status copy_running(const std::string& url, const std::string& data_dir, const std::string& folder);

/// A model for reading, whether it is at rest or runs: then it is a copy, gone with this object.
/// One in a cluster must be at rest.
class ReadableModel {
 public:
  /// Errors: those of ModelFolder::open and copy_running.
  static Result<ReadableModel> open(const std::string& data_dir, const std::string& url);
  ReadableModel(ReadableModel&& other) noexcept;
  ReadableModel& operator=(ReadableModel&&) = delete;
  ~ReadableModel();

  ModelFolder& operator*() { return *model_; }
  ModelFolder* operator->() { return &*model_; }

 private:
  ReadableModel() = default;

  std::string copy_;  ///< The folder to be removed, if any.
  std::optional<ModelFolder> model_;
};

}  // namespace voxatlas
