#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "base/check.hpp"
#include "render/image.hpp"

namespace voxatlas {
namespace {

/// TurboJPEG's compressor and the buffer it fills again and again.
class Compressor {
 public:
  Compressor() : handle_(tjInitCompress()) {}
  ~Compressor() {
    tjFree(buffer_);
    if (handle_ != nullptr) tjDestroy(handle_);
  }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  /// The bytes stay valid until the next call.
  Result<ByteView> compress(const Image& image, int quality) {
    if (handle_ == nullptr) return fail(ErrorCode::kIo, "TurboJPEG does not start");
    if (tjCompress2(handle_, reinterpret_cast<const unsigned char*>(image.pixels.data()),
                    image.width, 3 * image.width, image.height, TJPF_RGB, &buffer_, &size_,
                    TJSAMP_420, quality, TJFLAG_FASTDCT) != 0) {
      return fail(ErrorCode::kIo, fmt::format("TurboJPEG writes no picture of {} x {}: {}",
                                              image.width, image.height, tjGetErrorStr2(handle_)));
    }
    return ByteView{buffer_, size_};
  }

 private:
  tjhandle handle_;
  unsigned char* buffer_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

Result<Jpeg> encode_jpeg(const Image& image, int quality, std::size_t max_bytes) {
  VOX_CHECK(quality >= 1 && quality <= 100);
  Compressor compressor;
  Jpeg best;
  // The best quality that fits lies in (fits, too_much); a try that fills 7/8 of the room is taken.
  int fits = 0;
  int too_much = quality + 1;
  int next = quality;
  while (too_much - fits > 1) {
    auto bytes = compressor.compress(image, next);
    if (!bytes) return pass_on(bytes);
    if (bytes->size() <= max_bytes) {
      fits = next;
      best = {Bytes(bytes->begin(), bytes->end()), next};
      if (next == quality || bytes->size() >= max_bytes / 8 * 7) return best;
    } else {
      too_much = next;
    }
    next = fits + (too_much - fits) / 2;
  }
  if (fits == 0) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("a picture of {} x {} does not fit {} bytes as JPEG, at any quality",
                            image.width, image.height, max_bytes));
  }
  return best;
}

Result<Image> decode_jpeg(ByteView bytes) {
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 25;
  const std::unique_ptr<void, int (*)(tjhandle)> handle(tjInitDecompress(), tjDestroy);
  if (handle == nullptr) return fail(ErrorCode::kIo, "TurboJPEG does not start");
  int width = 0, height = 0, sampling = 0, space = 0;
  if (tjDecompressHeader3(handle.get(), bytes.data(), bytes.size(), &width, &height, &sampling,
                          &space) != 0) {
    return fail(ErrorCode::kCorrupt, fmt::format("{} bytes are no JPEG: {}", bytes.size(),
                                                 tjGetErrorStr2(handle.get())));
  }
  if (std::int64_t{width} * height > kMostPixels) {
    return fail(ErrorCode::kOutOfRange, fmt::format("a JPEG of {} x {} has more than {} pixels",
                                                    width, height, kMostPixels));
  }
  Image image(width, height);
  if (tjDecompress2(handle.get(), bytes.data(), bytes.size(),
                    reinterpret_cast<unsigned char*>(image.pixels.data()), width, 3 * width, height,
                    TJPF_RGB, 0) != 0) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("a JPEG of {} x {}: {}", width, height, tjGetErrorStr2(handle.get())));
  }
  return image;
}

}  // namespace voxatlas
