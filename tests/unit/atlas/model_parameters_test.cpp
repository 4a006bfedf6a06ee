#include "atlas/model_parameters.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <set>

namespace voxatlas {
namespace {

/// Each differs from the standard in one value, and says so by this name.
std::vector<std::pair<std::string, ModelParameters>> one_off() {
  std::vector<std::pair<std::string, ModelParameters>> list(11);
  const char* names[] = {"cells_per_metre", "hit ",       "miss ",         "clamp_min",
                         "clamp_max",       "free_depth", "surface_depth", "min_range",
                         "max_range",       "shards",     "all_rays_free"};
  for (std::size_t i = 0; i < list.size(); ++i) list[i].first = names[i];
  list[0].second.cells_per_metre = 5;
  ++list[1].second.sensor.hit;
  --list[2].second.sensor.miss;
  --list[3].second.sensor.clamp_min;
  ++list[4].second.sensor.clamp_max;
  list[5].second.integration.free_depth = 7;
  list[6].second.integration.surface_depth = 6;
  list[7].second.integration.min_range = 0.5;
  list[8].second.integration.max_range = 80.25;
  list[9].second.shards = 4;
  list[10].second.integration.all_rays_free = true;
  return list;
}

TEST_CASE("parameters come back as they went, cut nowhere", "[atlas]") {
  for (const auto& [name, parameters] : one_off()) {
    const auto bytes = encode_parameters(parameters);
    REQUIRE(decode_parameters(bytes).value() == parameters);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      REQUIRE(decode_parameters(ByteView(bytes).first(size)).error().code == ErrorCode::kCorrupt);
    }
  }
  auto bytes = encode_parameters({});
  bytes.push_back(0);
  REQUIRE(decode_parameters(bytes).error().code == ErrorCode::kCorrupt);
  bytes.pop_back();
  bytes[0] = 3;
  REQUIRE(decode_parameters(bytes).error().code == ErrorCode::kInvalid);
  bytes[0] = 2;
  bytes[1] = 21;  // Cells a metre: at most 20.
  REQUIRE(decode_parameters(bytes).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("models made before all_rays_free was told have it, byte for byte", "[atlas]") {
  ModelParameters old;
  old.integration.all_rays_free = true;
  const auto bytes = encode_parameters(old);
  REQUIRE(bytes.size() == encode_parameters({}).size() - 1);
  REQUIRE(bytes[0] == 1);
  REQUIRE(decode_parameters(bytes).value() == old);
  auto wrong = encode_parameters({});
  wrong.back() = 2;
  REQUIRE(decode_parameters(wrong).error().code == ErrorCode::kCorrupt);
}

TEST_CASE("one value that differs gives another id, and words that name it alone", "[atlas]") {
  const ModelParameters standard;
  std::set<std::int64_t> ids{parameters_id(standard)};
  REQUIRE(describe_difference(standard, standard).empty());
  for (const auto& [name, parameters] : one_off()) {
    REQUIRE(ids.insert(parameters_id(parameters)).second);
    REQUIRE(parameters_id(parameters) >= 0);
    const auto words = describe_difference(standard, parameters);
    CAPTURE(words);
    REQUIRE(words.rfind(name, 0) == 0);
    REQUIRE(words.find(';') == std::string::npos);
  }
  ModelParameters other;
  other.integration.free_depth = 7;
  other.shards = 2;
  REQUIRE(describe_difference(standard, other) == "free_depth 4, not 7; shards 1, not 2");
}

TEST_CASE("parameters that cannot be are named", "[atlas]") {
  const auto refused = [](const ModelParameters& parameters, const std::string& word) {
    const auto status = parameters.check();
    REQUIRE_FALSE(status.has_value());
    REQUIRE(status.error().code == ErrorCode::kOutOfRange);
    REQUIRE(status.error().message.find(word) != std::string::npos);
  };
  REQUIRE(ModelParameters{}.check().has_value());
  ModelParameters p;
  p.cells_per_metre = 21;
  refused(p, "21");
  p = {};
  p.sensor.hit = -1;
  refused(p, "hit -1");
  p = {};
  p.integration.max_range = std::numeric_limits<double>::quiet_NaN();
  refused(p, "max_range");
  p = {};
  p.shards = 0;
  refused(p, "shards");
}

}  // namespace
}  // namespace voxatlas
