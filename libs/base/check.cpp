#include "base/check.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "base/result.hpp"

namespace voxatlas {

void check_failed(const char* condition, const char* file, int line) {
  fmt::print(stderr, "{}:{}: check failed: {}\n", file, line, condition);
  std::abort();
}

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kOutOfRange:
      return "out_of_range";
    case ErrorCode::kInvalid:
      return "invalid";
    case ErrorCode::kCorrupt:
      return "corrupt";
    case ErrorCode::kNotFound:
      return "not_found";
    case ErrorCode::kIo:
      return "io";
    case ErrorCode::kNoSpace:
      return "no_space";
    case ErrorCode::kFenced:
      return "fenced";
    case ErrorCode::kUnknown:
      return "unknown";
    case ErrorCode::kUnavailable:
      return "unavailable";
  }
  return "?";
}

}  // namespace voxatlas
