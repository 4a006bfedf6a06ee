#include "tilestore/checkpoints.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "base/log.hpp"
#include "base/utime.hpp"

namespace voxatlas {

Checkpoints::Checkpoints(TileStore& store, std::string data_dir)
    : store_(store), data_dir_(std::move(data_dir)) {}

Checkpoints::~Checkpoints() {
  if (copying_.valid()) copying_.wait();
}

static Status copy_into(TileStore& store, const std::string& data_dir, const std::string& name,
                        std::int32_t shard) {
  if (data_dir.empty()) {
    return fail(ErrorCode::kInvalid,
                "the model lies in a cluster: stop the set, then use `voxatlas store copy`");
  }
  std::error_code error;
  const std::string folder = data_dir + "/" + name;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kIo, fmt::format("cannot make {}: {}", folder, error.message()));
  }
  return store.checkpoint(fmt::format("{}/shard-{}", folder, shard));
}

static std::string folder_for(const checkpoint_request_t& request) {
  return fmt::format("checkpoint-{:x}-{}", static_cast<std::uint64_t>(request.client),
                     static_cast<std::uint64_t>(request.id));
}

void Checkpoints::begin(const checkpoint_request_t& request) {
  question_ = {request.client, request.id};
  copying_ = std::async(std::launch::async, [this, request] {
    const auto began = steady_utime();
    const auto folder = folder_for(request);
    auto copied = copy_into(store_, data_dir_, folder, request.shard);
    if (copied) {
      log_info("{} made in {} ms", folder, (steady_utime() - began) / 1000);
    } else {
      log_error("{}: {}", folder, copied.error().message);
    }
    return copied;
  });
}

bool Checkpoints::is_busy() const {
  return copying_.valid() &&
         copying_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

std::optional<checkpoint_reply_t> Checkpoints::answer(const checkpoint_request_t& request) {
  if (copying_.valid() && !is_busy()) {
    if (answers_.size() >= kMostAnswers) answers_.clear();
    answers_.insert_or_assign(question_, copying_.get());
  }
  const auto answer = answers_.find({request.client, request.id});
  if (answer == answers_.end()) {
    if (!copying_.valid()) begin(request);
    return std::nullopt;
  }
  checkpoint_reply_t reply{};
  reply.utime = utime_now();
  reply.client = request.client;
  reply.id = request.id;
  reply.shard = request.shard;
  if (answer->second) {
    reply.folder = folder_for(request);
  } else {
    reply.error = answer->second.error().message;
  }
  return reply;
}

}  // namespace voxatlas
