#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "base/check.hpp"
#include "render/image.hpp"
#include "render/workers.hpp"

namespace voxatlas {
namespace {

constexpr int kUnit = 16;  // Pixels of a side of what 4:2:0 encodes at once.
constexpr int kParts = 8;  // Enough to share out; each costs a call.

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

  /// Rows first .. last - 1 as a picture of its own. False where TurboJPEG refuses: error() says
  /// why.
  bool compress(const Image& image, int first, int last, int quality) {
    const auto* pixels = image.pixels.data() +
                         static_cast<std::size_t>(first) * static_cast<std::size_t>(image.width);
    return handle_ != nullptr &&
           tjCompress2(handle_, reinterpret_cast<const unsigned char*>(pixels), image.width,
                       3 * image.width, last - first, TJPF_RGB, &buffer_, &size_, TJSAMP_420,
                       quality, TJFLAG_FASTDCT) == 0;
  }
  /// Valid until the next call.
  ByteView bytes() const { return {buffer_, size_}; }
  const char* error() const {
    return handle_ == nullptr ? "it does not start" : tjGetErrorStr2(handle_);
  }

 private:
  tjhandle handle_;
  unsigned char* buffer_ = nullptr;
  unsigned long size_ = 0;
};

/// A JPEG's segments up to its pixels, and these.
struct Segments {
  std::size_t height = 0;  ///< Where the frame's height stands,
  std::size_t scan = 0;    ///< where the scan's segment begins,
  std::size_t pixels = 0;  ///< and the pixels: from there to the end marker, 2 bytes.
};

/// Of what TurboJPEG wrote: one frame, one scan.
Segments segments_of(ByteView jpeg) {
  Segments found;
  for (std::size_t at = 2; found.pixels == 0;) {
    VOX_CHECK(at + 4 <= jpeg.size() && jpeg[at] == 0xff);
    const int marker = jpeg[at + 1];
    const std::size_t next = at + 2 + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);
    if (marker == 0xc0) found.height = at + 5;
    if (marker == 0xda) {
      found.scan = at;
      found.pixels = next;
    }
    at = next;
  }
  VOX_CHECK(found.height != 0 && found.pixels + 2 <= jpeg.size());
  return found;
}

void append(Bytes& bytes, ByteView more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

/// Encodes a picture in parts that lie one below the other, and joins them by restart markers: to a
/// decoder it is one picture, whose pixels are those of one encoded in a piece.
class PartedCompressor {
 public:
  PartedCompressor(const Image& image, Workers* workers) : image_(image), workers_(workers) {
    const auto up = [](int n, int of) { return std::max(1, (n + of - 1) / of); };
    units_across_ = up(image.width, kUnit);
    rows_ = kUnit * up(up(image.height, kUnit), kParts);
    compressors_ = std::vector<Compressor>(static_cast<std::size_t>(up(image.height, rows_)));
    good_.resize(compressors_.size());
  }

  Result<Bytes> compress(int quality) {
    const auto encode = [&](std::size_t part, std::size_t) {
      const int first = static_cast<int>(part) * rows_;
      const int last = std::min(image_.height, first + rows_);
      good_[part] = compressors_[part].compress(image_, first, last, quality);
    };
    if (workers_ != nullptr) {
      workers_->run(compressors_.size(), encode);
    } else {
      for (std::size_t part = 0; part < compressors_.size(); ++part) encode(part, 0);
    }
    for (std::size_t part = 0; part < compressors_.size(); ++part) {
      if (good_[part]) continue;
      return fail(ErrorCode::kIo,
                  fmt::format("TurboJPEG writes no picture of {} x {}: {}", image_.width,
                              image_.height, compressors_[part].error()));
    }
    return joined();
  }

 private:
  Bytes joined() const {
    const ByteView first = compressors_[0].bytes();
    const Segments segments = segments_of(first);
    const int interval = units_across_ * (rows_ / kUnit);
    VOX_CHECK(interval <= 0xffff);  // A picture would have 2^27 pixels; cameras end at 2^25.
    Bytes bytes;
    append(bytes, first.first(segments.scan));
    bytes[segments.height] = static_cast<std::uint8_t>(image_.height >> 8);
    bytes[segments.height + 1] = static_cast<std::uint8_t>(image_.height);
    append(bytes, std::array<std::uint8_t, 6>{0xff, 0xdd, 0, 4,  // A marker every `interval` units.
                                              static_cast<std::uint8_t>(interval >> 8),
                                              static_cast<std::uint8_t>(interval)});
    append(bytes, first.subspan(segments.scan, first.size() - segments.scan - 2));
    for (std::size_t part = 1; part < compressors_.size(); ++part) {
      const ByteView own = compressors_[part].bytes();
      const std::size_t pixels = segments_of(own).pixels;
      append(bytes,
             std::array<std::uint8_t, 2>{0xff, static_cast<std::uint8_t>(0xd0 + (part - 1) % 8)});
      append(bytes, own.subspan(pixels, own.size() - pixels - 2));
    }
    append(bytes, std::array<std::uint8_t, 2>{0xff, 0xd9});
    return bytes;
  }

  const Image& image_;
  Workers* workers_;
  int units_across_;
  int rows_;                             // Of a part.
  std::vector<Compressor> compressors_;  // One a part,
  std::vector<char> good_;               // and whether it did.
};

/// At which quality a picture that took `size` bytes at `quality` is likely to fill most of `room`:
/// bytes go about as the power -0.6 of what libjpeg divides by.
int likely_quality(int quality, std::size_t size, std::size_t room) {
  constexpr double kMost = 0.95, kPower = 1.6;
  const double divisor = std::max(1.0, quality < 50 ? 5000.0 / quality : 200.0 - 2 * quality);
  const double ratio = static_cast<double>(size) / (kMost * static_cast<double>(room));
  const double wanted = divisor * std::pow(ratio, kPower);
  return static_cast<int>(wanted > 100 ? 5000 / wanted : 100 - wanted / 2);
}

}  // namespace

Result<Jpeg> encode_jpeg(const Image& image, int quality, std::size_t max_bytes, Workers* workers) {
  VOX_CHECK(quality >= 1 && quality <= 100);
  PartedCompressor compressor(image, workers);
  Jpeg best;
  // The best quality that fits lies in (fits, too_much); a try that fills 7/8 of the room is taken.
  int fits = 0;
  int too_much = quality + 1;
  int next = quality;
  constexpr int kGuesses = 3;  // Then halves: for a picture that is not like others.
  int tries = 0;
  while (too_much - fits > 1) {
    auto bytes = compressor.compress(next);
    if (!bytes) return pass_on(bytes);
    const std::size_t size = bytes->size();
    if (size <= max_bytes) {
      fits = next;
      best = {std::move(*bytes), next};
      if (next == quality || size >= max_bytes / 8 * 7) return best;
    } else {
      too_much = next;
    }
    const int guess = likely_quality(next, size, max_bytes);
    next = ++tries < kGuesses ? std::clamp(guess, fits + 1, std::max(fits + 1, too_much - 1))
                              : fits + (too_much - fits) / 2;
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
