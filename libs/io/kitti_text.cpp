#include "io/kitti_text.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "geodesy/ecef.hpp"

namespace voxatlas {
namespace {

constexpr double kLatestSeconds = 1e11;  // Microseconds of it fit 64 bits with room.
constexpr double kLowestMetres = -12'000, kHighestMetres = 20'000;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// What a person sees of a value that may be anything: short, printable.
std::string quoted(std::string_view text) {
  std::string shown = "'";
  for (const char c : text.substr(0, 32)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (text.size() > 32 ? "...'" : "'");
}

std::string place(const std::string& file, std::size_t line) {
  return fmt::format("{}: line {}", file, line);
}

/// Lines of a text with their numbers; blank ones at its end do not count. A last line without a
/// line break may be one that was cut.
class Lines {
 public:
  explicit Lines(std::string_view text)
      : rest_(text), ends_open_(!text.empty() && text.back() != '\n') {
    while (!rest_.empty() && (is_blank(rest_.back()) || rest_.back() == '\n')) {
      rest_.remove_suffix(1);
    }
  }
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const auto end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }
  bool may_be_cut() const { return rest_.empty() && ends_open_; }

 private:
  std::string_view rest_;
  bool ends_open_;
  std::size_t number_ = 0;
};

Result<double> parse_number(std::string_view word, const std::string& where) {
  double value = 0;
  const char* begin = word.data() + (word.front() == '+' ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: {} is not a number", where, quoted(word)));
  }
  return value;
}

template <std::size_t N>
struct Numbers {
  std::array<double, N> values{};
  std::size_t count = 0;
};

template <std::size_t N>
Result<Numbers<N>> parse_numbers(std::string_view line, const std::string& where) {
  Numbers<N> numbers;
  while (true) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.empty()) return numbers;
    std::size_t length = 0;
    while (length < line.size() && !is_blank(line[length])) ++length;
    if (numbers.count == N) {
      return fail(ErrorCode::kCorrupt, fmt::format("{}: {} after the {} numbers of a line", where,
                                                   quoted(line.substr(0, length)), N));
    }
    auto value = parse_number(line.substr(0, length), where);
    if (!value) return pass_on(value);
    numbers.values[numbers.count++] = *value;
    line.remove_prefix(length);
  }
}

template <class T, std::size_t N, class Make>
Result<T> parse_entry(std::string_view line, const std::string& where, Make make) {
  auto numbers = parse_numbers<N>(line, where);
  if (!numbers) return pass_on(numbers);
  if (numbers->count < N) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: {} of {} numbers", where, numbers->count, N));
  }
  return make(numbers->values, where);
}

/// One entry of N numbers a line; `make` turns them, and where they stand, into a Result<T>.
template <class T, std::size_t N, class Make>
Result<ParsedLines<T>> parse_lines(std::string_view text, const std::string& file, Make make) {
  ParsedLines<T> parsed;
  Lines lines(text);
  for (std::string_view line; lines.next(line);) {
    const std::string where = place(file, lines.number());
    auto entry = parse_entry<T, N>(line, where, make);
    if (!entry && lines.may_be_cut()) {  // Too few numbers, half of one as "1e", or a wrong one.
      parsed.ending = std::move(entry.error());
      return parsed;
    }
    if (!entry) return pass_on(entry);
    parsed.entries.push_back(*entry);
  }
  return parsed;
}

Result<Pose> make_pose(const std::array<double, 12>& numbers, const std::string& where,
                       const std::optional<Pose>& ecef_from_local) {
  auto pose = Pose::from_rows(numbers);
  if (pose && ecef_from_local) pose = *ecef_from_local * *pose;
  if (!pose) return pass_on(pose, where);
  const Eigen::Vector3d& p_ecef = pose->translation();
  const auto place = to_geodetic(p_ecef);
  if (!place || !(place->height >= kLowestMetres && place->height <= kHighestMetres)) {
    return fail(
        ErrorCode::kOutOfRange,
        fmt::format("{}: position {} {} {} is not on the Earth{}", where, numbers[3], numbers[7],
                    numbers[11], ecef_from_local ? "" : " (a local frame needs its origin)"));
  }
  return pose;
}

}  // namespace

Result<ParsedLines<std::int64_t>> parse_kitti_times(std::string_view text,
                                                    const std::string& file) {
  return parse_lines<std::int64_t, 1>(
      text, file,
      [](const std::array<double, 1>& n, const std::string& where) -> Result<std::int64_t> {
        if (n[0] < 0 || n[0] > kLatestSeconds) {
          return fail(ErrorCode::kOutOfRange,
                      fmt::format("{}: {} is no time in unix seconds", where, n[0]));
        }
        return std::llround(n[0] * 1e6);
      });
}

Result<ParsedLines<Pose>> parse_kitti_poses(std::string_view text, const std::string& file,
                                            const std::optional<Pose>& ecef_from_local) {
  return parse_lines<Pose, 12>(text, file,
                               [&](const std::array<double, 12>& n, const std::string& where) {
                                 return make_pose(n, where, ecef_from_local);
                               });
}

}  // namespace voxatlas
