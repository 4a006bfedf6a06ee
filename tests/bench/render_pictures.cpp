#include "bench/render_pictures.hpp"

#include <fmt/format.h>

#include <deque>

#include "geodesy/ecef.hpp"
#include "geodesy/enu_frame.hpp"
#include "render/frustum.hpp"
#include "render/supersample.hpp"

namespace voxatlas::bench {
namespace {

constexpr int kFreeDepth = 4;
constexpr std::size_t kMostBytes = 10'000'000;  // More than any quality needs.

class Album {
 public:
  Album(const Grid& grid, const std::vector<PlacedTree>& trees, const PictureFiles& files)
      : grid_(grid), trees_(trees), files_(files) {}

  void add(const std::string& name, const Camera& camera, const PaintOptions& options,
           int side = 1) {
    Supersample mean(camera, side);
    while (!mean.complete()) {
      or_throw(painter_.paint(mean.next(), grid_, trees_, options, painting_));
      mean.add(painting_.image);
    }
    if (files_.jpeg_quality > 0) {
      const auto jpeg = or_throw(encode_jpeg(mean.image(), files_.jpeg_quality, kMostBytes));
      write_file(files_.folder / (name + ".jpg"), jpeg.bytes);
    } else {
      write_file(files_.folder / (name + ".png"), or_throw(encode_png(mean.image())));
    }
  }

 private:
  const Grid& grid_;
  const std::vector<PlacedTree>& trees_;
  PictureFiles files_;
  Painter painter_{2};
  Painting painting_;
};

/// From 150 m above, north up, four pixels a metre.
Camera map_above(const Camera& view) {
  const auto frame = or_throw(EnuFrame::at(view.position()));
  Lens lens = Lens::of_map(4, view.width(), view.height());
  return or_throw(Camera::look_at(frame.to_ecef({0, 0, 150}), frame.to_ecef({0, 0, 0}),
                                  frame.north_ecef(), lens));
}

void add_free_space(const Model& model, const Grid& grid, const View& view, Album& album) {
  std::vector<TileKey> keys;
  for (const auto& [key, tile] : model) keys.push_back(key);
  std::deque<FreeCells> cells;
  std::vector<PlacedFree> free;
  for (const TileKey key : tiles_in_view(view.camera, grid, keys)) {
    free.push_back({key, &cells.emplace_back(model.at(key), kFreeDepth)});
  }
  PaintOptions options;
  options.free = free;
  album.add(view.name + "_free", view.camera, options, 2);
}

}  // namespace

void write_pictures(const Model& model, const Grid& grid, const std::vector<PlacedTree>& trees,
                    const std::vector<View>& views, const PictureFiles& files) {
  Album album(grid, trees, files);
  for (const View& view : views) {
    album.add(view.name, view.camera, {}, 4);
    add_free_space(model, grid, view, album);
    PaintOptions boxes;
    boxes.overlay = {true, true, true, true};
    album.add(view.name + "_boxes", view.camera, boxes, 2);
  }
  const View& first = views.front();
  for (int i = 0; i <= static_cast<int>(Colouring::kNormal); ++i) {
    PaintOptions options;
    options.colouring = static_cast<Colouring>(i);
    album.add(fmt::format("{}_{}", first.name, name_of(options.colouring)), first.camera, options);
  }
  for (int depth = 0; depth < kDepth; ++depth) {
    PaintOptions options;
    options.splat.max_depth = depth;
    album.add(fmt::format("{}_depth{}", first.name, depth), first.camera, options);
  }
  PaintOptions filled, gl, map;
  filled.fill_holes = true;
  album.add(first.name + "_filled", first.camera, filled);
  gl.backend = Backend::kGl;
  album.add(first.name + "_gl", first.camera, gl);
  map.overlay = {false, true, true, true};
  album.add("map", map_above(first.camera), map, 2);
}

}  // namespace voxatlas::bench
