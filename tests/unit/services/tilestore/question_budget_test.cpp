#include "tilestore/question_budget.hpp"

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

TEST_CASE("without import every question is answered", "[tilestore]") {
  QuestionBudget budget;
  for (std::int64_t now = 0; now < 1'000'000; now += 1000) {
    REQUIRE(budget.allows(now));
    budget.spend(100'000);
  }
}

TEST_CASE("while scans come in, questions take no more than their share", "[tilestore][oracle]") {
  auto rng = test::engine();
  INFO("VOX_SEED=" << test::seed());
  QuestionBudget budget;
  std::int64_t now = 1, spent = 0;
  const std::int64_t begin = now;
  while (now < 10'000'000) {
    budget.delta_came(now);
    now += 1 + static_cast<std::int64_t>(rng() % 2000);
    if (!budget.allows(now)) continue;
    const auto took = static_cast<std::int64_t>(rng() % 5000);
    budget.spend(took);
    spent += took;
    now += took;
  }
  const auto share = (now - begin) / QuestionBudget::kShare;
  CHECK(spent <= share + QuestionBudget::kMostUs + 5000);
  CHECK(spent >= share * 8 / 10);  // And it is theirs.
}

TEST_CASE("when the import rests, all are answered again", "[tilestore]") {
  QuestionBudget budget;
  budget.delta_came(0);
  budget.spend(10'000'000);
  CHECK_FALSE(budget.allows(QuestionBudget::kImportUs));
  CHECK(budget.allows(QuestionBudget::kImportUs + 1));
}

}  // namespace
}  // namespace voxatlas
