#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.hpp"

namespace voxatlas {

/// A place where OpenGL (compatibility profile) draws without a screen: here OSMesa's llvmpipe, on
/// the CPU. The only file that knows which is gl_context.cpp; EGL surfaceless may take its place.
///
/// Threads: one at a time; begin() makes the context current on the calling thread.
class GlContext {
 public:
  /// Errors: kUnavailable where no context can be made.
  static Result<std::unique_ptr<GlContext>> create();
  ~GlContext();

  /// Clears, and directs GL to a picture of this size.
  /// Errors: kOutOfRange for a size that GL's viewport has not, kUnavailable where GL refuses.
  Status begin(int width, int height);

  /// Finishes drawing. The colour of each pixel as r | g << 8 | b << 16 | a << 24, and its depth in
  /// the window's terms, 0 near .. 2^32 - 1 far; both from the upper left, row by row.
  /// Errors: kIo where GL has met an error since begin().
  struct Pixels {
    std::vector<std::uint32_t> colour;
    std::vector<std::uint32_t> depth;
  };
  Status finish(Pixels& pixels);

 private:
  struct State;
  explicit GlContext(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace voxatlas
