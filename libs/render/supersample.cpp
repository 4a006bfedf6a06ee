#include "render/supersample.hpp"

#include "base/check.hpp"

namespace voxatlas {

Supersample::Supersample(const Camera& camera, int side) : camera_(camera), side_(side) {
  VOX_CHECK(side >= 1 && side <= kMaxSide);
  sums_.resize(std::size_t{3} * static_cast<std::size_t>(camera.width()) *
               static_cast<std::size_t>(camera.height()));
}

Camera Supersample::next() const {
  VOX_CHECK(!complete());
  const auto from_middle = [this](int step) { return (step + 0.5) / side_ - 0.5; };
  return camera_.shifted(from_middle(added_ % side_), from_middle(added_ / side_));
}

void Supersample::add(const Image& image) {
  VOX_CHECK(!complete() && image.width == camera_.width() && image.height == camera_.height());
  std::uint16_t* sum = sums_.data();
  for (const Rgb pixel : image.pixels) {
    *sum = static_cast<std::uint16_t>(*sum + pixel.r), ++sum;
    *sum = static_cast<std::uint16_t>(*sum + pixel.g), ++sum;
    *sum = static_cast<std::uint16_t>(*sum + pixel.b), ++sum;
  }
  ++added_;
}

Image Supersample::image() const {
  VOX_CHECK(added_ > 0);
  Image image(camera_.width(), camera_.height());
  const std::uint16_t* sum = sums_.data();
  const auto mean = [&] { return static_cast<std::uint8_t>((*sum++ + added_ / 2) / added_); };
  for (Rgb& pixel : image.pixels) {
    pixel.r = mean();
    pixel.g = mean();
    pixel.b = mean();
  }
  return image;
}

}  // namespace voxatlas
