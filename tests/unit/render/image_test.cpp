#include "render/image.hpp"

#include <turbojpeg.h>

#include <catch2/catch.hpp>
#include <random>

#include "render/workers.hpp"
#include "support/engine.hpp"

namespace voxatlas {
namespace {

Image noise(int width, int height) {
  auto rng = test::engine();
  Image image(width, height);
  for (Rgb& pixel : image.pixels) {
    const auto bits = rng();
    pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16)};
  }
  return image;
}

Image gradient(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y) = {static_cast<std::uint8_t>(x * 255 / width),
                        static_cast<std::uint8_t>(y * 255 / height), 60};
    }
  }
  return image;
}

/// Oracle: TurboJPEG's own decoder.
Image decoded_by_turbojpeg(const Bytes& bytes) {
  tjhandle handle = tjInitDecompress();
  int width = 0, height = 0, sampling = 0, colours = 0;
  REQUIRE(tjDecompressHeader3(handle, bytes.data(), bytes.size(), &width, &height, &sampling,
                              &colours) == 0);
  Image image(width, height);
  REQUIRE(tjDecompress2(handle, bytes.data(), bytes.size(),
                        reinterpret_cast<unsigned char*>(image.pixels.data()), width, 3 * width,
                        height, TJPF_RGB, 0) == 0);
  tjDestroy(handle);
  return image;
}

TEST_CASE("a PNG gives back every pixel", "[image][oracle]") {
  for (const auto& [w, h] : {std::pair{1, 1}, {7, 3}, {640, 360}}) {
    const Image image = noise(w, h);
    const auto bytes = encode_png(image);
    REQUIRE(bytes.has_value());
    const auto back = decode_png(*bytes);
    REQUIRE(back.has_value());
    REQUIRE(*back == image);
  }
}

TEST_CASE("bytes that are no PNG are refused, not believed", "[image]") {
  const Bytes good = encode_png(gradient(64, 64)).value();
  for (std::size_t size = 0; size < good.size() - 12; size += 37) {
    const auto cut = decode_png(ByteView(good).first(size));
    REQUIRE_FALSE(cut.has_value());
    REQUIRE(cut.error().code == ErrorCode::kCorrupt);
  }
  auto rng = test::engine();
  for (int i = 0; i < 300; ++i) {
    Bytes bytes = good;
    bytes[rng() % bytes.size()] ^= static_cast<std::uint8_t>(1 + rng() % 255);
    (void)decode_png(bytes).has_value();  // Any answer, but no crash.
  }
  Bytes huge = good;  // Width and height of 2^24 in the header: refused before memory is taken.
  huge[16] = huge[20] = 1;
  REQUIRE_FALSE(decode_png(huge).has_value());
}

TEST_CASE("a JPEG looks like its picture", "[image][oracle]") {
  const Image image = gradient(320, 200);
  const auto jpeg = encode_jpeg(image, 85, 150'000);
  REQUIRE(jpeg.has_value());
  REQUIRE(jpeg->quality == 85);
  const Image back = decode_jpeg(jpeg->bytes).value();
  REQUIRE(back == decoded_by_turbojpeg(jpeg->bytes));
  REQUIRE(back.width == 320);
  double sum = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    sum += std::abs(image.pixels[i].g - back.pixels[i].g);
  }
  REQUIRE(sum / static_cast<double>(image.pixels.size()) < 3);
}

/// Oracle: TurboJPEG's own encoder, in a piece.
Bytes encoded_by_turbojpeg(const Image& image, int quality) {
  tjhandle handle = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  REQUIRE(tjCompress2(handle, reinterpret_cast<const unsigned char*>(image.pixels.data()),
                      image.width, 3 * image.width, image.height, TJPF_RGB, &buffer, &size,
                      TJSAMP_420, quality, TJFLAG_FASTDCT) == 0);
  Bytes bytes(buffer, buffer + size);
  tjFree(buffer);
  tjDestroy(handle);
  return bytes;
}

TEST_CASE("a JPEG encoded in parts has the pixels of one encoded in a piece", "[image][oracle]") {
  Workers workers(3);
  for (const auto& [w, h] : {std::pair{1, 1}, {16, 16}, {17, 129}, {640, 360}, {35, 721}}) {
    CAPTURE(w, h);
    const Image image = noise(w, h);
    const auto jpeg = encode_jpeg(image, 70, 100'000'000, &workers);
    REQUIRE(jpeg.has_value());
    REQUIRE(jpeg->bytes == encode_jpeg(image, 70, 100'000'000)->bytes);
    REQUIRE(decode_jpeg(jpeg->bytes).value() ==
            decoded_by_turbojpeg(encoded_by_turbojpeg(image, 70)));
  }
  REQUIRE_FALSE(encode_jpeg(Image(), 70, 1000, &workers).has_value());
}

TEST_CASE("what is no JPEG is refused, whatever is broken", "[image]") {
  REQUIRE(decode_jpeg({}).error().code == ErrorCode::kCorrupt);
  REQUIRE(decode_jpeg(Bytes(1000, 7)).error().code == ErrorCode::kCorrupt);
  Bytes bytes = encode_jpeg(noise(64, 36), 85, 100'000)->bytes;
  bytes.resize(20);
  REQUIRE_FALSE(decode_jpeg(bytes).has_value());
}

TEST_CASE("a JPEG's quality falls until it fits, and no further than it must", "[image]") {
  const Image image = noise(640, 360);  // Nothing is larger than noise.
  const auto large = encode_jpeg(image, 85, 10'000'000);
  REQUIRE(large->quality == 85);
  for (const std::size_t room : {150'000u, 100'000u, 60'000u}) {
    const auto jpeg = encode_jpeg(image, 85, room);
    REQUIRE(jpeg.has_value());
    REQUIRE(jpeg->bytes.size() <= room);
    REQUIRE(jpeg->quality < 85);
    const auto better = encode_jpeg(image, jpeg->quality + 1, 10'000'000);
    const bool close = jpeg->bytes.size() >= room / 8 * 7;
    REQUIRE((close || better->bytes.size() > room));
  }
  const auto none = encode_jpeg(image, 85, 500);
  REQUIRE_FALSE(none.has_value());
  REQUIRE(none.error().code == ErrorCode::kOutOfRange);
  REQUIRE_THAT(none.error().message, Catch::Contains("640 x 360"));
}

}  // namespace
}  // namespace voxatlas
