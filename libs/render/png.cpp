#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <string>

#include "render/image.hpp"

namespace voxatlas {
namespace {

/// What libpng's callbacks write to.
struct PngSink {
  Bytes bytes;
  std::string error;
};

void keep_bytes(png_structp png, png_bytep data, std::size_t size) {
  auto& sink = *static_cast<PngSink*>(png_get_io_ptr(png));
  sink.bytes.insert(sink.bytes.end(), data, data + size);
}

[[noreturn]] void keep_error(png_structp png, png_const_charp message) {
  static_cast<PngSink*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// libpng leaves by longjmp, so nothing with a destructor may live in here.
bool write_rows(png_structp png, png_infop info, const Image& image) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, 1);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_write_info(png, info);
  for (int y = 0; y < image.height; ++y) {
    const Rgb* row =
        image.pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
    png_write_row(png, reinterpret_cast<png_const_bytep>(row));
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

Result<Bytes> encode_png(const Image& image) {
  PngSink sink;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, keep_error, ignore_warning);
  if (png == nullptr) return fail(ErrorCode::kIo, "libpng does not start");
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &sink, keep_bytes, nullptr);
  const bool written = info != nullptr && write_rows(png, info, image);
  png_destroy_write_struct(&png, &info);
  if (!written) {
    return fail(ErrorCode::kIo, fmt::format("libpng writes no picture of {} x {}: {}", image.width,
                                            image.height, sink.error));
  }
  return std::move(sink.bytes);
}

Result<Image> decode_png(ByteView bytes) {
  constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 25;
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) == 0) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("PNG of {} bytes: {}", bytes.size(), header.message));
  }
  if (std::uint64_t{header.width} * header.height > kMaxPixels) {
    png_image_free(&header);
    return fail(ErrorCode::kOutOfRange, fmt::format("PNG of {} x {} has more than {} pixels",
                                                    header.width, header.height, kMaxPixels));
  }
  header.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(header.width), static_cast<int>(header.height));
  if (png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr) == 0) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("PNG of {} bytes: {}", bytes.size(), header.message));
  }
  return image;
}

}  // namespace voxatlas
