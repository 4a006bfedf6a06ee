#pragma once

namespace voxatlas {

/// Prints the broken condition and where it stands, then aborts. Use VOX_CHECK.
[[noreturn]] void check_failed(const char* condition, const char* file, int line);

}  // namespace voxatlas

/// A bug if false: on in every build, stops the process. Never for input from outside.
#define VOX_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::voxatlas::check_failed(#condition, __FILE__, __LINE__))
