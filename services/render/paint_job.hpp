#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "grid/grid.hpp"
#include "render/painter.hpp"
#include "render/supersample.hpp"

namespace voxatlas {

/// How a picture goes out: render_request_t's numbers.
enum class PictureFormat : std::int8_t { kJpeg = 0, kPng = 1, kRaw = 2 };
enum class DepthFormat : std::int8_t { kNone = 0, kSteps = 1, kMetres = 2 };

struct EncodeOptions {
  PictureFormat format = PictureFormat::kJpeg;
  DepthFormat depth = DepthFormat::kNone;
  std::size_t most_bytes = 150'000;  ///< Of picture and depth image together.
  int jpeg_quality = 85;             ///< Where that fits.
};

/// The trees of one picture, held while it is drawn whatever comes in meanwhile.
struct PictureTrees {
  std::vector<PlacedTree> placed;
  std::vector<PlacedFree> free;                         ///< Of one depth; empty: none is drawn.
  std::vector<std::shared_ptr<const RenderTree>> held;  // Shared with the cache.
  std::vector<std::shared_ptr<const FreeCells>> held_free;
};

/// A picture to be drawn and encoded, or one of those that a supersampled one is the mean of.
struct PaintJob {
  std::uint64_t ticket = 0;  ///< Comes back.
  Camera camera;
  std::shared_ptr<const PictureTrees> trees;  ///< Shared by the pictures of one supersampled one.
  PaintOptions how;                           ///< Its free space is the trees'.
  EncodeOptions encode;
  std::unique_ptr<Supersample> mean;  ///< Null: a plain picture, of the camera.
};

struct PaintedPicture {
  std::uint64_t ticket = 0;
  Status sound;  ///< Errors: Painter's, the encoders', and kOutOfRange for one that is too large.
  std::unique_ptr<Supersample> mean;  ///< The job's; not complete: there are no data yet.
  Bytes data;
  int quality = 0;  ///< JPEG's.
  Bytes depth_data;
  double depth_scale = 0;  ///< Metres a step; 1 where it is in metres.
  int depth = 0;           ///< Of the deepest cells drawn.
  std::size_t tiles = 0;
  std::uint64_t cells = 0;
  double draw_ms = 0, shade_ms = 0, overlay_ms = 0, encode_ms = 0;
  double all_ms = 0;  ///< Of this job.
};

/// Paints and encodes, in a thread of its own.
///
/// Threads: one at a time.
class PaintRoom {
 public:
  PaintRoom(const Grid& grid, std::size_t threads) : grid_(grid), painter_(threads) {}

  PaintedPicture paint(PaintJob job);

 private:
  Status paint(PaintJob& job, PaintedPicture& picture);
  Status encode(const Image& image, const EncodeOptions& options, PaintedPicture& picture);
  Status encode_depth(const Camera& camera, const EncodeOptions& options,
                      PaintedPicture& picture) const;

  Grid grid_;
  Painter painter_;
  Painting painting_;  // Kept: a picture's memory is used by the next.
};

}  // namespace voxatlas
