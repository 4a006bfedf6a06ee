#include "hub/channel_pattern.hpp"

#include <fmt/format.h>
#include <regex.h>

#include <catch2/catch.hpp>
#include <string>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

std::string random_pattern(std::mt19937_64& rng, int depth) {
  std::string text;
  for (auto parts = rng() % 4; parts > 0; --parts) {
    switch (rng() % 6) {
      case 0:
        text += '.';
        break;
      case 1:
        text += rng() % 2 == 0 ? "[ab]" : "[^a-b]";
        break;
      case 2:
        text += depth > 0 ? fmt::format("({}|{})", random_pattern(rng, depth - 1),
                                        random_pattern(rng, depth - 1))
                          : "\\.";
        break;
      default:
        text += static_cast<char>('a' + rng() % 3);
    }
    if (rng() % 3 == 0) text += "*+?"[rng() % 3];
  }
  return text;
}

/// Oracle: the C library's extended regular expressions.
class PosixPattern {
 public:
  explicit PosixPattern(const std::string& text) {
    REQUIRE(::regcomp(&pattern_, fmt::format("^({})$", text).c_str(), REG_EXTENDED | REG_NOSUB) ==
            0);
  }
  ~PosixPattern() { ::regfree(&pattern_); }
  PosixPattern(const PosixPattern&) = delete;
  PosixPattern& operator=(const PosixPattern&) = delete;

  bool matches(const std::string& name) const {
    return ::regexec(&pattern_, name.c_str(), 0, nullptr, 0) == 0;
  }

 private:
  regex_t pattern_{};
};

TEST_CASE("a channel pattern agrees with the C library's regular expressions", "[hub][oracle]") {
  auto rng = test::engine();
  for (int i = 0; i < 5000; ++i) {
    const auto text = random_pattern(rng, 2);
    const auto pattern = ChannelPattern::parse(text);
    CAPTURE(text);
    REQUIRE(pattern.has_value());
    const PosixPattern oracle(text);
    for (int n = 0; n < 20; ++n) {
      std::string name;
      for (auto length = rng() % 6; length > 0; --length) name += "abc."[rng() % 4];
      CAPTURE(name);
      REQUIRE(pattern->matches(name) == oracle.matches(name));
    }
  }
}

TEST_CASE("what is no pattern is refused by name", "[hub]") {
  const std::string text = GENERATE(as<std::string>{}, "*a", "a**", "(a", "a)", "[a", "a{2}", "\\",
                                    "\\d", "^a", "a$", "[z-a]", "a]");
  CAPTURE(text);
  const auto pattern = ChannelPattern::parse(text);
  REQUIRE_FALSE(pattern.has_value());
  REQUIRE(pattern.error().code == ErrorCode::kInvalid);
  REQUIRE(pattern.error().message.find(text) != std::string::npos);
}

TEST_CASE("a pattern made to keep the hub busy does not", "[hub]") {
  std::string hostile;
  for (int i = 0; i < 40; ++i) hostile += "(a*)*";
  const auto pattern = ChannelPattern::parse(hostile + "b");
  REQUIRE(pattern.has_value());
  CHECK_FALSE(pattern->matches(std::string(256, 'a')));
  CHECK_FALSE(ChannelPattern::parse(std::string(200, '(')).has_value());
  CHECK_FALSE(ChannelPattern::parse(std::string(100, '(') + std::string(100, ')')).has_value());
}

TEST_CASE("any bytes are a pattern or are refused", "[hub]") {
  auto rng = test::engine();
  const std::string signs = "ab().*+?|[]^-\\$";
  for (int i = 0; i < 50'000; ++i) {
    std::string text;
    for (auto length = rng() % 12; length > 0; --length) text += signs[rng() % signs.size()];
    const auto pattern = ChannelPattern::parse(text);
    if (pattern) pattern->matches("ab");
  }
}

}  // namespace
}  // namespace voxatlas
