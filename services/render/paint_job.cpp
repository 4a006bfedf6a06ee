#include "render/paint_job.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/utime.hpp"
#include "render/depth_image.hpp"
#include "render/image.hpp"

namespace voxatlas {
namespace {

double milliseconds_since(std::int64_t start) {
  return static_cast<double>(steady_utime() - start) / 1000;
}

/// The farthest that 16 bits count, with one to spare for what lies beyond.
double metres_a_step(const Camera& camera) {
  constexpr double kSteps = 65'534;
  return camera.lens().far_range / kSteps;
}

Bytes raw_bytes(const Image& image) {
  const auto* first = reinterpret_cast<const std::uint8_t*>(image.pixels.data());
  return Bytes(first, first + image.pixels.size() * sizeof(Rgb));
}

}  // namespace

PaintedPicture PaintRoom::paint(PaintJob job) {
  const std::int64_t start = steady_utime();
  PaintedPicture picture;
  picture.ticket = job.ticket;
  picture.sound = paint(job, picture);
  picture.mean = std::move(job.mean);
  picture.all_ms = milliseconds_since(start);
  return picture;
}

Status PaintRoom::paint(PaintJob& job, PaintedPicture& picture) {
  const Camera camera = job.mean ? job.mean->next() : job.camera;
  job.how.free = job.trees->free;
  if (auto painted = painter_.paint(camera, grid_, job.trees->placed, job.how, painting_);
      !painted) {
    return painted;
  }
  picture.depth = painting_.depth;
  picture.tiles = painting_.tiles;
  picture.cells = painting_.cells_in_view;
  picture.draw_ms = painting_.draw_ms;
  picture.shade_ms = painting_.shade_ms;
  picture.overlay_ms = painting_.overlay_ms;
  const std::int64_t start = steady_utime();
  if (job.mean) {
    job.mean->add(painting_.image);
    if (!job.mean->complete()) return {};
    painting_.image = job.mean->image();
  }
  auto encoded = encode(painting_.image, job.encode, picture);
  if (encoded) encoded = encode_depth(camera, job.encode, picture);
  picture.encode_ms = milliseconds_since(start);
  return encoded;
}

Status PaintRoom::encode(const Image& image, const EncodeOptions& options,
                         PaintedPicture& picture) {
  if (options.format == PictureFormat::kJpeg) {
    auto jpeg = encode_jpeg(image, options.jpeg_quality, options.most_bytes, &painter_.workers());
    if (!jpeg) return pass_on(jpeg);
    picture.quality = jpeg->quality;
    picture.data = std::move(jpeg->bytes);
    return {};
  }
  if (options.format == PictureFormat::kRaw) {
    picture.data = raw_bytes(image);
  } else {
    auto png = encode_png(image);
    if (!png) return pass_on(png);
    picture.data = std::move(*png);
  }
  if (picture.data.size() <= options.most_bytes) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("a picture of {} x {} has {} bytes, more than the {} a stream takes",
                          image.width, image.height, picture.data.size(), options.most_bytes));
}

Status PaintRoom::encode_depth(const Camera& camera, const EncodeOptions& options,
                               PaintedPicture& picture) const {
  if (options.depth == DepthFormat::kNone) return {};
  if (options.depth == DepthFormat::kMetres) {
    picture.depth_scale = 1;
    picture.depth_data = depth_metres(painting_.cells);
  } else {
    picture.depth_scale = metres_a_step(camera);
    auto steps = depth_steps(painting_.cells, picture.depth_scale);
    if (!steps) return pass_on(steps);
    picture.depth_data = std::move(*steps);
  }
  const std::size_t sum = picture.data.size() + picture.depth_data.size();
  if (sum <= options.most_bytes) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("a picture of {} x {} with its depth image has {} bytes, more than the "
                          "{} a stream takes",
                          camera.width(), camera.height(), sum, options.most_bytes));
}

}  // namespace voxatlas
