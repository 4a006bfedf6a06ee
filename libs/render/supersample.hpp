#pragma once

#include <cstdint>
#include <vector>

#include "render/camera.hpp"
#include "render/image.hpp"

namespace voxatlas {

/// The mean of several pictures of one view whose rays lie evenly spread within each pixel: what a
/// camera that rests shows in the end. One picture at a time, so that others' fit between.
///
///     while (!mean.complete()) { paint(mean.next(), ...); mean.add(painting.image); }
class Supersample {
 public:
  static constexpr int kMaxSide = 16;

  /// `side` x `side` rays a pixel, 1..kMaxSide; 1 is the plain picture.
  explicit Supersample(const Camera& camera, int side = 4);

  bool complete() const { return added_ == side_ * side_; }
  /// The camera of the next picture; not complete().
  Camera next() const;
  /// Its picture, as large as the camera says.
  void add(const Image& image);
  /// The mean of those added, rounded to nearest; at least one.
  Image image() const;

 private:
  Camera camera_;
  int side_;
  int added_ = 0;
  std::vector<std::uint16_t> sums_;  // Red, green, blue of each pixel.
};

}  // namespace voxatlas
