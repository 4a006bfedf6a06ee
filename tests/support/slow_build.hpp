#pragma once

namespace voxatlas::test {

/// Whether this build is slow: what takes long is then done less often, as its results are the
/// release build's to judge and its memory and arithmetic the sanitizers'.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool kSlowBuild = false;
#else
inline constexpr bool kSlowBuild = true;
#endif

}  // namespace voxatlas::test
