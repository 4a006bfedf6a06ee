#include "ingest/ingest_service.hpp"

#include <poll.h>

#include <catch2/catch.hpp>
#include <map>

#include "geodesy/ecef.hpp"
#include "grid/region_key.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

ModelParameters parameters_for(std::uint32_t shards) {
  ModelParameters parameters;
  parameters.shards = shards;
  return parameters;
}

/// Rays from a sensor in Munich to points all around it, within 60 m.
SensorScan random_scan(std::mt19937_64& rng) {
  std::normal_distribution<float> spread(0, 20);
  SensorScan scan;
  const auto p_ecef = to_ecef({48.1489, 11.5680, 520}).value();
  scan.ecef_from_sensor = Pose::create(Eigen::Matrix3d::Identity(), p_ecef).value();
  for (int i = 0; i < 300; ++i) {
    scan.points_sensor.emplace_back(spread(rng), spread(rng), spread(rng));
  }
  return scan;
}

/// All that the workers finish until nothing is under way.
std::vector<IngestService::Outgoing> wait_for(IngestService& service, std::size_t scans) {
  std::vector<IngestService::Outgoing> result;
  while (result.size() < scans) {
    pollfd event{service.fd(), POLLIN, 0};
    poll(&event, 1, -1);
    for (auto& outgoing : service.finished()) result.push_back(std::move(outgoing));
  }
  return result;
}

/// Oracle: the integrator alone, its tiles by shard.
std::map<std::uint64_t, Bytes> tiles_of(const SensorScan& scan, const ModelParameters& parameters) {
  Integrator integrator(parameters.grid(), parameters.integration);
  auto delta = integrator.integrate(to_scan(scan, 0.02, 0));
  std::map<std::uint64_t, Bytes> tiles;
  for (const auto& [key, tile_delta] : delta->tiles) {
    encode_delta(tile_delta, tiles[key.morton()]);
  }
  return tiles;
}

TEST_CASE("every shard gets its part of every scan, and the parts are the whole", "[ingest]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  const auto shards = GENERATE(1u, 3u);
  const auto parameters = parameters_for(shards);
  IngestService service(parameters, 2);
  std::map<std::int64_t, SensorScan> scans;
  for (std::int64_t seq = 0; seq < 8; ++seq) {
    scans[seq] = random_scan(rng);
    service.take(to_message(scans[seq], {"car", 9, seq}, 0.02, 0), {1, seq});
  }
  for (const auto& outgoing : wait_for(service, scans.size())) {
    REQUIRE(outgoing.shards.size() == shards);
    auto expected = tiles_of(scans.at(outgoing.shards[0].seq), parameters);
    for (std::uint32_t shard = 0; shard < shards; ++shard) {
      const auto& message = outgoing.shards[shard];
      REQUIRE(message.source == "car");
      REQUIRE(message.session == 9);
      REQUIRE(message.parameters == parameters_id(parameters));
      ByteReader reader(message.data);
      for (std::int32_t i = 0; i < message.tiles; ++i) {
        const auto key = TileKey::from_morton(reader.get<std::uint64_t>()).value();
        const ByteView delta = reader.get_bytes(reader.get<std::uint32_t>());
        REQUIRE(shard_of(key, shards) == shard);
        REQUIRE(Bytes(delta.begin(), delta.end()) == expected.at(key.morton()));
        expected.erase(key.morton());
      }
      REQUIRE(reader.at_end());
    }
    REQUIRE(expected.empty());
  }
}

TEST_CASE("a scan is acknowledged when all shards have it, in its stream's order", "[ingest]") {
  auto rng = test::engine();
  IngestService service(parameters_for(2), 1);
  for (std::int64_t seq = 0; seq < 3; ++seq) {
    service.take(to_message(random_scan(rng), {"car", 9, seq}, 0.02, 0), {4, 10 + seq});
  }
  std::map<std::int64_t, std::uint64_t> scan_of_seq;
  for (const auto& outgoing : wait_for(service, 3))
    scan_of_seq[outgoing.shards[0].seq] = outgoing.scan;

  service.committed(scan_of_seq[1], 0);
  service.committed(scan_of_seq[1], 1);  // The middle one is done, but the first is not.
  REQUIRE(service.acknowledged().empty());
  service.committed(scan_of_seq[0], 0);
  REQUIRE(service.acknowledged().empty());
  service.committed(scan_of_seq[0], 1);
  const auto first = service.acknowledged();
  REQUIRE(first.size() == 1);
  REQUIRE(first[0].session == 4);
  REQUIRE(first[0].number == 11);
  REQUIRE(service.acknowledged().empty());
  service.committed(scan_of_seq[2], 1);
  service.committed(scan_of_seq[2], 0);
  REQUIRE(service.acknowledged().at(0).number == 12);
  REQUIRE(service.in_flight() == 0);
}

TEST_CASE("a scan that cannot be integrated still takes its place, empty", "[ingest]") {
  auto rng = test::engine();
  IngestService service(parameters_for(2), 1);
  scan_t bad_sigma = to_message(random_scan(rng), {"car", 9, 0}, -1, 0);
  scan_t bad_pose = to_message(random_scan(rng), {"car", 9, 1}, 0.02, 0);
  bad_pose.ecef_from_sensor[0] = 5;
  service.take(bad_sigma, {});
  service.take(bad_pose, {});
  for (const auto& outgoing : wait_for(service, 2)) {
    for (const auto& message : outgoing.shards) {
      REQUIRE(message.tiles == 0);
      REQUIRE(message.size == 0);
    }
  }
  REQUIRE(service.counters().refused == 2);
}

TEST_CASE("scans that wait in the shards keep no other out, but plain scans", "[ingest]") {
  auto rng = test::engine();
  const auto scan = random_scan(rng);
  IngestService service(parameters_for(1), 1);
  constexpr std::int64_t kMost = IngestService::kMaxInFlight;
  const auto fill = [&](std::string source, StreamRef from) {
    for (std::int64_t seq = 0; seq < kMost; ++seq) {
      REQUIRE(service.has_room());
      service.take(to_message(scan, {source, 9, seq}, 0.02, 0), from);
    }
    REQUIRE_FALSE(service.has_room());  // Until they are integrated.
    return wait_for(service, kMost);
  };
  fill("car", {4, 1});
  REQUIRE(service.has_room_for_plain());
  const auto plain = fill("car~plain", {});
  REQUIRE(service.has_room());
  REQUIRE_FALSE(service.has_room_for_plain());
  service.committed(plain[0].scan, 0);
  REQUIRE(service.has_room_for_plain());
}

TEST_CASE("what is no scan is dropped and does not block its stream", "[ingest]") {
  IngestService service(parameters_for(1), 1);
  service.take_message(MessageKind::kScan, as_bytes("garbage"), {6, 0});
  service.take_message(MessageKind::kTileRaw, as_bytes("garbage"), {6, 1});
  scan_t nameless{};
  nameless.parts = 1;
  service.take(nameless, {6, 2});
  REQUIRE(service.counters().unidentified == 3);
  REQUIRE(service.acknowledged().at(0).number == 2);
}

TEST_CASE("what is acknowledged from a source's start on is told to the shards", "[ingest]") {
  auto rng = test::engine();
  IngestService service(parameters_for(1), 1);
  for (std::int64_t seq = 0; seq < 3; ++seq) {
    service.take(to_message(random_scan(rng), {"car", 9, seq}, 0.02, 0), {4, seq});
    const auto outgoing = wait_for(service, 1);
    REQUIRE(outgoing[0].shards[0].acked_below == seq);
    service.committed(outgoing[0].scan, 0);
  }
  // A source whose start another ingest had: nothing is known of it.
  service.take(to_message(random_scan(rng), {"bus", 9, 7}, 0.02, 0), {4, 3});
  const auto outgoing = wait_for(service, 1);
  service.committed(outgoing[0].scan, 0);
  service.take(to_message(random_scan(rng), {"bus", 9, 8}, 0.02, 0), {4, 4});
  REQUIRE(wait_for(service, 1)[0].shards[0].acked_below == 0);
}

}  // namespace
}  // namespace voxatlas
