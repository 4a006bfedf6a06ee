#include "cli/model_client.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/sha256.hpp"
#include "bus/service_loop.hpp"

namespace voxatlas {

namespace {

constexpr std::size_t kPlainRowBytes = 16;
constexpr std::size_t kDetailedRowBytes = 80;

ModelClient::TileRow read_row(ByteReader& reader, bool details) {
  ModelClient::TileRow row;
  row.key = reader.get<std::uint64_t>();
  row.version = reader.get<std::uint64_t>();
  if (!details) return row;
  Sha256Digest digest{};
  const ByteView hash = reader.get_bytes(digest.size());
  std::ranges::copy(hash, digest.begin());
  row.hash = to_hex(digest);
  row.encoded_bytes = reader.get<std::uint32_t>();
  row.leaves = reader.get<std::uint32_t>();
  row.occupied_leaves = reader.get<std::uint32_t>();
  row.free_leaves = reader.get<std::uint32_t>();
  row.occupied_voxels = reader.get<std::uint32_t>();
  row.free_voxels = reader.get<std::uint32_t>();
  reader.get<std::uint64_t>();
  return row;
}

}  // namespace

Result<std::unique_ptr<ModelClient>> ModelClient::connect(const std::string& url) {
  auto client = std::make_unique<ModelClient>();
  client->self_ = Endpoint::for_this_client();
  client->id_ = random_id();
  auto bus = Bus::create(url);
  if (!bus) return pass_on(bus);
  client->bus_ = std::move(*bus);
  ConsumerConfig config;
  config.client = client->id_;
  auto in = InLink::create(*client->bus_, client->self_, config);
  if (!in) return pass_on(in);
  client->in_ = std::move(*in);
  client->stores_ =
      std::make_unique<StoreClient>(*client->bus_, client->in_->port(), client->self_);
  if (auto asked = client->ask_all_shards(); !asked) return pass_on(asked);
  return client;
}

Status ModelClient::ask_all_shards() {
  std::int32_t shards = 1;
  for (std::int32_t shard = 0; shard < shards; ++shard) {
    auto reply = stores_->model(shard, "", 0, kPatience);
    if (!reply) {
      return pass_on(reply, fmt::format("no answer on {} (is the set running? scripts/up starts it "
                                        "and says its URL)",
                                        bus_->url()));
    }
    auto parameters = decode_parameters(reply->parameters);
    if (!parameters) return pass_on(parameters, fmt::format("tilestore {}", shard));
    parameters_ = *parameters;
    disk_bytes_ += reply->disk_bytes;
    shards = static_cast<std::int32_t>(parameters_.shards);
  }
  return {};
}

Result<std::int64_t> ModelClient::durable_up_to(const std::string& source, std::int64_t session) {
  std::int64_t least = INT64_MAX;
  for (std::uint32_t shard = 0; shard < parameters_.shards; ++shard) {
    auto reply = stores_->model(static_cast<std::int32_t>(shard), source, session, kPatience);
    if (!reply) return pass_on(reply);
    least = std::min(least, reply->mark);
  }
  return least;
}

Status ModelClient::for_each_tile(bool details, const std::function<void(const TileRow&)>& visit) {
  for (std::uint32_t shard = 0; shard < parameters_.shards; ++shard) {
    auto listed =
        list_shard(static_cast<std::int32_t>(shard), TileBox{}, details, kPatience, visit);
    if (!listed) return listed;
  }
  return {};
}

Status ModelClient::list_shard(std::int32_t shard, const TileBox& box, bool details,
                               std::int64_t timeout_us,
                               const std::function<void(const TileRow&)>& visit) {
  const auto last = parameters_.grid().tiles_per_axis() - 1;
  tiles_request_t request{};
  request.shard = shard;
  request.details = details ? 1 : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    request.min_index[axis] = static_cast<std::int32_t>(std::min(box.min[axis], last));
    request.max_index[axis] = static_cast<std::int32_t>(std::min(box.max[axis], last));
  }
  while (request.from >= 0) {
    if (stop_requested()) return fail(ErrorCode::kUnavailable, "stopped");
    auto reply = stores_->tiles(request, timeout_us);
    if (!reply) return pass_on(reply);
    const std::size_t row_bytes = details ? kDetailedRowBytes : kPlainRowBytes;
    if (reply->rows.size() != static_cast<std::size_t>(reply->tiles) * row_bytes ||
        (reply->next >= 0 && reply->next <= request.from)) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("tilestore {}: a page of {} tiles in {} bytes, from {}, next {}",
                              shard, reply->tiles, reply->rows.size(), request.from, reply->next));
    }
    ByteReader reader(reply->rows);
    while (reader.remaining() > 0) visit(read_row(reader, details));
    request.from = reply->next;
  }
  return {};
}

}  // namespace voxatlas
