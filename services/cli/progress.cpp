#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "base/utime.hpp"

namespace voxatlas {

namespace {

constexpr std::int64_t kEvery = 1'000'000;

}  // namespace

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1), next_(steady_utime() + kEvery) {}

Progress::~Progress() {
  if (open_line_) fmt::print(stderr, "\n");
}

bool Progress::due() const { return steady_utime() >= next_; }

void Progress::say(std::string_view text) {
  if (!due()) return;
  next_ = steady_utime() + kEvery;
  if (terminal_) {
    fmt::print(stderr, "\r\x1b[K{}", text);
    std::fflush(stderr);
    open_line_ = true;
  } else {
    fmt::print(stderr, "{}\n", text);
  }
}

}  // namespace voxatlas
