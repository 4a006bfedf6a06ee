#include "hub/channel_pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace voxatlas {

/// Recursive descent, from the back: each part is told what follows it, so that an automaton
/// without loose ends grows (Thompson's construction). Hence the parts of a sequence are found
/// first.
class PatternParser {
 public:
  using Step = ChannelPattern::Step;

  PatternParser(std::string_view text, std::vector<Step>& steps) : text_(text), steps_(steps) {}

  /// text_[first, last) followed by `next`; returns where it starts.
  std::int32_t alternatives(std::size_t first, std::size_t last, std::int32_t next, int nesting) {
    if (nesting > ChannelPattern::kMaxNesting) return refuse(first, "nested too deeply");
    const auto bar = find_bar(first, last);
    const auto one = sequence(first, bar, next, nesting);
    if (bar == last) return one;
    return fork(one, alternatives(bar + 1, last, next, nesting + 1));
  }

  Status status() const {
    if (problem_ == nullptr) return {};
    return fail(ErrorCode::kInvalid,
                fmt::format("channel pattern '{}': {} at {}", text_, problem_, problem_at_));
  }

 private:
  struct Part {
    std::size_t first, last;  ///< Without its repetition.
    char repeat;              ///< * + ? or 0.
  };

  std::int32_t sequence(std::size_t first, std::size_t last, std::int32_t next, int nesting) {
    std::vector<Part> parts;
    for (auto at = first; at < last && problem_ == nullptr;) {
      const auto end = end_of_part(at, last);
      const char repeat = end < last && is_repeat(text_[end]) ? text_[end] : '\0';
      parts.push_back({at, end, repeat});
      at = end + (repeat != 0 ? 1 : 0);
    }
    for (auto part = parts.rbegin(); part != parts.rend() && problem_ == nullptr; ++part) {
      next = repeated(*part, next, nesting);
    }
    return next;
  }

  std::int32_t repeated(const Part& part, std::int32_t next, int nesting) {
    if (part.repeat == 0) return single(part, next, nesting);
    if (part.repeat == '?') return fork(single(part, next, nesting), next);
    const auto loop = fork(-1, next);
    const auto body = single(part, loop, nesting);
    steps_[static_cast<std::size_t>(loop)].next = body;
    return part.repeat == '+' ? body : loop;
  }

  std::int32_t single(const Part& part, std::int32_t next, int nesting) {
    const char sign = text_[part.first];
    if (sign == '(') return alternatives(part.first + 1, part.last - 1, next, nesting + 1);
    Step step;
    step.reads = true;
    step.next = next;
    if (sign == '.') {
      step.signs.set();
    } else if (sign == '[') {
      read_set(part, step.signs);
    } else {
      step.signs.set(static_cast<std::uint8_t>(text_[part.last - 1]));  // After a backslash, too.
    }
    return add(std::move(step));
  }

  void read_set(const Part& part, std::bitset<256>& signs) {
    auto at = part.first + 1;
    const auto end = part.last - 1;
    const bool inverse = at < end && text_[at] == '^';
    for (at += inverse ? 1 : 0; at < end; ++at) {
      const auto low = static_cast<std::uint8_t>(text_[at]);
      auto high = low;
      if (at + 2 < end && text_[at + 1] == '-') high = static_cast<std::uint8_t>(text_[at += 2]);
      if (high < low) refuse(at, "range the wrong way round");
      for (unsigned sign = low; sign <= high; ++sign) signs.set(sign);
    }
    if (inverse) signs.flip();
  }

  /// Where the part that begins at `at` ends.
  std::size_t end_of_part(std::size_t at, std::size_t last) {
    const char sign = text_[at];
    if (is_repeat(sign)) return refuse_part(at, "nothing to repeat", last);
    if (std::string_view(")]{}^$").find(sign) != std::string_view::npos) {
      return refuse_part(at, "sign not known here", last);
    }
    if (sign == '\\') {
      const bool known =
          at + 1 < last && std::isalnum(static_cast<std::uint8_t>(text_[at + 1])) == 0;
      return known ? at + 2 : refuse_part(at, "escape not known", last);
    }
    if (sign == '[') {
      const auto end = text_.find(']', at + 2);
      return end < last ? end + 1 : refuse_part(at, "set not closed", last);
    }
    if (sign != '(') return at + 1;
    const auto end = find_closing(at, last);
    return end < last ? end + 1 : refuse_part(at, "group not closed", last);
  }

  std::size_t find_closing(std::size_t at, std::size_t last) const {
    int depth = 0;
    for (; at < last; at = skip(at)) {
      if (text_[at] == '(') ++depth;
      if (text_[at] == ')' && --depth == 0) return at;
    }
    return last;
  }

  /// The first | outside of groups, or `last`.
  std::size_t find_bar(std::size_t first, std::size_t last) const {
    int depth = 0;
    for (auto at = first; at < last; at = skip(at)) {
      if (text_[at] == '(') ++depth;
      if (text_[at] == ')') --depth;
      if (text_[at] == '|' && depth == 0) return at;
    }
    return last;
  }

  /// The place after the sign at `at`, with what it escapes or the set it opens.
  std::size_t skip(std::size_t at) const {
    if (text_[at] == '\\') return at + 2;
    if (text_[at] != '[') return at + 1;
    const auto end = text_.find(']', at + 2);
    return end == std::string_view::npos ? text_.size() : end + 1;
  }

  static bool is_repeat(char sign) { return sign == '*' || sign == '+' || sign == '?'; }

  std::int32_t fork(std::int32_t one, std::int32_t other) {
    Step step;
    step.next = one;
    step.other = other;
    return add(std::move(step));
  }

  std::int32_t add(Step step) {
    steps_.push_back(std::move(step));
    return static_cast<std::int32_t>(steps_.size()) - 1;
  }

  std::int32_t refuse(std::size_t at, const char* problem) {
    if (problem_ == nullptr) problem_at_ = at;
    if (problem_ == nullptr) problem_ = problem;
    return ChannelPattern::kEnd;
  }

  std::size_t refuse_part(std::size_t at, const char* problem, std::size_t last) {
    refuse(at, problem);
    return last;
  }

  std::string_view text_;
  std::vector<Step>& steps_;
  const char* problem_ = nullptr;
  std::size_t problem_at_ = 0;
};

Result<ChannelPattern> ChannelPattern::parse(std::string_view text) {
  if (text.size() > kMaxLength) {
    return fail(ErrorCode::kInvalid,
                fmt::format("channel pattern of {} signs, at most {}", text.size(), kMaxLength));
  }
  ChannelPattern pattern;
  PatternParser parser(text, pattern.steps_);
  pattern.start_ = parser.alternatives(0, text.size(), kEnd, 0);
  if (auto status = parser.status(); !status) return pass_on(status);
  return pattern;
}

/// Marks the steps that can be reached without reading; the last mark is the end's.
void ChannelPattern::reach(std::int32_t step, std::vector<bool>& reached) const {
  std::vector<std::int32_t> open{step};
  while (!open.empty()) {
    const auto at = open.back();
    open.pop_back();
    if (at == -1) continue;
    const auto mark = at == kEnd ? steps_.size() : static_cast<std::size_t>(at);
    if (reached[mark]) continue;
    reached[mark] = true;
    if (at == kEnd || steps_[mark].reads) continue;
    open.push_back(steps_[mark].next);
    open.push_back(steps_[mark].other);
  }
}

bool ChannelPattern::matches(std::string_view name) const {
  std::vector<bool> here(steps_.size() + 1);
  reach(start_, here);
  for (const char sign : name) {
    std::vector<bool> after(steps_.size() + 1);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (!here[i] || !steps_[i].reads) continue;
      if (steps_[i].signs[static_cast<std::uint8_t>(sign)]) reach(steps_[i].next, after);
    }
    here = std::move(after);
  }
  return here.back();
}

}  // namespace voxatlas
