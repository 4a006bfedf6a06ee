#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/model_parameters.hpp"
#include "atlas/tile_mirror.hpp"
#include "base/result.hpp"
#include "bus/bus.hpp"
#include "bus/requests.hpp"
#include "bus/stream_link.hpp"

namespace voxatlas {

/// The command line's place on the bus: its connection, its own port for answers and streams, and
/// the running model it talks to.
///
/// Errors: connect: kUnavailable where the bus cannot be joined or no tilestore answers, saying
/// what to
///         do. Threads: one at a time.
class ModelClient {
 public:
  static constexpr std::int64_t kPatience = 10'000'000;  ///< For an answer, microseconds.

  /// Joins the bus and learns the model's parameters from shard 0.
  static Result<std::unique_ptr<ModelClient>> connect(const std::string& url);

  Bus& bus() { return *bus_; }
  InLink& in() { return *in_; }
  StoreClient& stores() { return *stores_; }
  std::int32_t port_offset() const { return self_.port_offset(); }
  /// Random, for requests: streams that answer them are told by it, even where clients share a
  /// port.
  std::int64_t id() const { return id_; }
  const ModelParameters& parameters() const { return parameters_; }
  std::int64_t disk_bytes() const { return disk_bytes_; }  ///< Of all shards, at connect.

  /// The least of all shards' marks: every scan up to it is durable everywhere. -1: none is.
  Result<std::int64_t> durable_up_to(const std::string& source, std::int64_t session);

  struct TileRow {
    std::uint64_t key = 0, version = 0;
    std::string hash;  ///< Hexadecimal; with details only, as what follows.
    std::uint32_t encoded_bytes = 0, leaves = 0, occupied_leaves = 0, free_leaves = 0;
    std::uint32_t occupied_voxels = 0, free_voxels = 0;
  };
  /// Every tile of every shard, page by page, each shard ascending by key.
  Status for_each_tile(bool details, const std::function<void(const TileRow&)>& visit);
  /// Those of one shard that lie in a box; each page may take `timeout_us`.
  Status list_shard(std::int32_t shard, const TileBox& box, bool details, std::int64_t timeout_us,
                    const std::function<void(const TileRow&)>& visit);

 private:
  Status ask_all_shards();

  Endpoint self_;
  std::int64_t id_ = 0;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<InLink> in_;
  std::unique_ptr<StoreClient> stores_;
  ModelParameters parameters_;
  std::int64_t disk_bytes_ = 0;
};

}  // namespace voxatlas
