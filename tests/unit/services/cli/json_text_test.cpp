#include "cli/json_text.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace voxatlas {
namespace {

TEST_CASE("an object is one line with its names in order, and every number survives", "[cli]") {
  JsonObject inner;
  inner.add("tiles", std::int64_t{3});
  JsonObject object;
  object.add("largest", std::numeric_limits<std::int64_t>::max())
      .add("third", 1.0 / 3)
      .add("name", "two\nlines and \"quotes\"")
      .add("model", inner);

  const std::string text = object.text();

  REQUIRE(text.find('\n') == std::string::npos);
  REQUIRE(text.find("largest") < text.find("third"));
  REQUIRE(text.find("name") < text.find("model"));
  const auto read = nlohmann::json::parse(text);
  REQUIRE(read["largest"].get<std::int64_t>() == std::numeric_limits<std::int64_t>::max());
  REQUIRE(read["third"].get<double>() == 1.0 / 3);
  REQUIRE(read["name"].get<std::string>() == "two\nlines and \"quotes\"");
  REQUIRE(read["model"]["tiles"].get<int>() == 3);
}

TEST_CASE("what JSON cannot say is written in another way, not thrown over", "[cli]") {
  JsonObject object;
  object.add("source", std::string("car\xff\xfe")).add("ratio", std::nan(""));
  const auto read = nlohmann::json::parse(object.text());
  REQUIRE(read["source"].get<std::string>() == "car\xEF\xBF\xBD\xEF\xBF\xBD");
  REQUIRE(read["ratio"].is_null());
}

TEST_CASE("an object without names is an empty object", "[cli]") {
  REQUIRE(JsonObject().text() == "{}");
}

}  // namespace
}  // namespace voxatlas
