#include "store/store_location.hpp"

#include <catch2/catch.hpp>

#include "support/temp_dir.hpp"

namespace voxatlas {
namespace {

TEST_CASE("a place in a cluster says conf, pool, model and client, a folder itself", "[store]") {
  const auto folder = StoreLocation::parse("data/a,b").value();
  CHECK(folder.embedded());
  CHECK(folder.folder == "data/a,b");
  const auto least = StoreLocation::parse("rados:/etc/ceph/ceph.conf,tiles").value();
  CHECK_FALSE(least.embedded());
  CHECK(least.cluster.conf == "/etc/ceph/ceph.conf");
  CHECK(least.cluster.pool == "tiles");
  CHECK(least.cluster.model == "voxatlas");
  CHECK(least.cluster.client == "client.admin");
  const auto all = StoreLocation::parse("rados:c,p,munich,client.voxatlas").value();
  CHECK(all.cluster.model == "munich");
  CHECK(all.cluster.client == "client.voxatlas");
  CHECK(StoreLocation::parse(all.text()).value().text() == all.text());
}

TEST_CASE("a place that cannot be meant is refused and named", "[store]") {
  for (const char* text :
       {"", "rados:", "rados:c", "rados:c,", "rados:,p", "rados:c,p,", "rados:c,p,m,n,o"}) {
    const auto place = StoreLocation::parse(text);
    CAPTURE(text);
    REQUIRE_FALSE(place.has_value());
    CHECK(place.error().code == ErrorCode::kInvalid);
    CHECK(place.error().message.find(text) != std::string::npos);
  }
}

TEST_CASE("a folder's shards are stores of their own", "[store]") {
  const test::TempDir folder;
  const auto place = StoreLocation::parse(folder / "model").value();
  const auto first = open_store(place, 0);
  const auto second = open_store(place, 1);
  REQUIRE(first.has_value());
  REQUIRE(second.has_value());
  REQUIRE((*first)->acquire(0).value() == 1);
  REQUIRE_FALSE(open_store(place, 0).has_value());
}

TEST_CASE("a cluster that is not there, or cannot be spoken to, is a clear error", "[store]") {
  const auto place = StoreLocation::parse("rados:/no/such.conf,tiles").value();
  const auto opened = open_store(place, 0);
  REQUIRE_FALSE(opened.has_value());
  CHECK(opened.error().code == ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace voxatlas
