#include "render/picture.hpp"

#include "base/utime.hpp"
#include "render/eye_dome.hpp"

namespace voxatlas {

Result<std::unique_ptr<PictureMaker>> PictureMaker::create() {
  auto scene = GlScene::create();
  if (!scene) return pass_on(scene);
  return std::unique_ptr<PictureMaker>(new PictureMaker(std::move(*scene)));
}

Result<Picture> PictureMaker::make(const Camera& camera, const Grid& grid,
                                   std::span<const PlacedCloud> clouds,
                                   const PictureOptions& options) {
  const auto milliseconds_since = [](std::int64_t start) {
    return static_cast<double>(steady_utime() - start) / 1000;
  };
  Picture picture;
  const CellNumbers numbers(clouds);
  picture.cells_drawn = numbers.count();
  const std::int64_t start = steady_utime();
  auto cells = scene_->draw(camera, grid, clouds);
  if (!cells) return pass_on(cells);
  picture.cells = std::move(*cells);
  picture.draw_ms = milliseconds_since(start);

  const std::int64_t drawn = steady_utime();
  if (options.fill_holes) fill_holes(picture.cells);
  picture.image = shade(picture.cells, numbers, camera, grid, scene_heights(camera, grid, clouds),
                        options.colouring);
  picture.shade_ms = milliseconds_since(drawn);
  return picture;
}

}  // namespace voxatlas
