#include "bus/reply_cache.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

Bytes answer_to(const ReplyCache::Question& question, std::size_t size) {
  return Bytes(size,
               static_cast<std::uint8_t>(question.type * 31 + question.client * 7 + question.id));
}

TEST_CASE("a question asked again gets the answer given before", "[bus]") {
  ReplyCache cache(1000, 100);
  const ReplyCache::Question question{1, 2, 3};
  CHECK(cache.find(question, 0) == nullptr);
  cache.keep(question, Bytes(10, 7), 0);
  cache.keep(question, Bytes(10, 8), 1);  // Answered twice: the first stays.
  REQUIRE(cache.find(question, 100) != nullptr);
  CHECK(*cache.find(question, 100) == Bytes(10, 7));
  CHECK(cache.find({2, 2, 3}, 0) == nullptr);  // Of another type,
  CHECK(cache.find({1, 3, 3}, 0) == nullptr);  // client
  CHECK(cache.find({1, 2, 4}, 0) == nullptr);  // or number.
  CHECK(cache.find(question, 101) == nullptr);
}

TEST_CASE("an answer larger than the cache is not kept, and costs no other", "[bus]") {
  ReplyCache cache(100, 100);
  cache.keep({1, 1, 1}, Bytes(60), 0);
  cache.keep({1, 1, 2}, Bytes(101), 0);
  CHECK(cache.find({1, 1, 1}, 0) != nullptr);
  CHECK(cache.find({1, 1, 2}, 0) == nullptr);
}

TEST_CASE("whatever is kept, only the newest that fit are found", "[bus][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  constexpr std::size_t kBytes = 5000;
  constexpr std::int64_t kAge = 200;
  ReplyCache cache(kBytes, kAge);
  struct Kept {
    ReplyCache::Question question;
    std::size_t size;
    std::int64_t given;
  };
  std::vector<Kept> kept;  // All, oldest first.
  std::int64_t now = 0;
  for (std::int64_t i = 0; i < 3000; ++i) {
    now += static_cast<std::int64_t>(rng() % 20);
    const ReplyCache::Question question{static_cast<std::int64_t>(rng() % 2), 5, i};
    const std::size_t size = rng() % 1000;
    cache.keep(question, answer_to(question, size), now);
    kept.push_back({question, size, now});
    std::size_t bytes = 0;
    bool fits = true;
    for (auto one = kept.rbegin(); one != kept.rend() && one - kept.rbegin() < 100; ++one) {
      bytes += one->size;
      fits = fits && bytes <= kBytes && now - one->given <= kAge;
      const auto* found = cache.find(one->question, now);
      REQUIRE((found != nullptr) == fits);
      if (found) REQUIRE(*found == answer_to(one->question, one->size));
    }
  }
}

}  // namespace
}  // namespace voxatlas
