#include "render/painter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "base/utime.hpp"
#include "render/eye_dome.hpp"
#include "render/frustum.hpp"

namespace voxatlas {
namespace {

constexpr std::array kBackends = {"splat", "gl"};

double milliseconds_since(std::int64_t start) {
  return static_cast<double>(steady_utime() - start) / 1000;
}

/// Those with anything to draw.
std::vector<PlacedTree> in_view(const Camera& camera, const Grid& grid,
                                std::span<const PlacedTree> trees) {
  const Frustum frustum(camera);
  std::vector<PlacedTree> seen;
  for (const PlacedTree& placed : trees) {
    if (!placed.tree->empty() && frustum.may_see(grid.box(placed.key))) seen.push_back(placed);
  }
  return seen;
}

/// The maker of a thing that is made when it is first wanted.
template <class Thing>
Status make(std::unique_ptr<Thing>& thing) {
  if (thing != nullptr) return {};
  auto made = Thing::create();
  if (!made) return pass_on(made);
  thing = std::move(*made);
  return {};
}

}  // namespace

const char* name_of(Backend backend) { return kBackends[static_cast<std::size_t>(backend)]; }

Result<Backend> backend_of(const std::string& name) {
  for (std::size_t i = 0; i < kBackends.size(); ++i) {
    if (name == kBackends[i]) return static_cast<Backend>(i);
  }
  return fail(ErrorCode::kInvalid,
              fmt::format("backend \"{}\" is not one of {}", name, fmt::join(kBackends, ", ")));
}

Status Painter::paint(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
                      const PaintOptions& options, Painting& painting) {
  const std::int64_t start = steady_utime();
  if (auto drawn = draw(camera, grid, trees, options, painting); !drawn) return drawn;
  painting.draw_ms = milliseconds_since(start);

  const std::int64_t shading = steady_utime();
  if (options.fill_holes) fill_holes(painting.cells);
  const auto seen = in_view(camera, grid, trees);
  shade(painting.cells, TreeNumbers(trees), camera, grid, scene_heights(camera, grid, seen),
        options.colouring, splatter_.workers(), painting.image);
  painting.shade_ms = milliseconds_since(shading);

  const std::int64_t over = steady_utime();
  auto drawn_over = draw_over(camera, grid, seen, options, painting);
  painting.overlay_ms = milliseconds_since(over);
  return drawn_over;
}

Status Painter::draw(const Camera& camera, const Grid& grid, std::span<const PlacedTree> trees,
                     const PaintOptions& options, Painting& painting) {
  if (options.backend == Backend::kSplat) {
    auto drawn = splatter_.draw(camera, grid, trees, options.splat, painting.cells);
    painting.depth = splatter_.drawn().depth;
    painting.tiles = splatter_.drawn().tiles;
    painting.cells_in_view = splatter_.drawn().cells;
    return drawn;
  }
  if (auto made = make(gl_); !made) return made;
  const int depth = options.splat.max_depth;
  if (auto drawn = gl_->draw(camera, grid, trees, depth, painting.cells); !drawn) return drawn;
  const auto seen = in_view(camera, grid, trees);
  painting.depth = 0;
  painting.tiles = seen.size();
  painting.cells_in_view = 0;
  for (const PlacedTree& placed : seen) {
    painting.depth = std::max(painting.depth, std::min(depth, placed.tree->depth()));
    painting.cells_in_view += placed.tree->cell_count(depth);
  }
  return {};
}

Status Painter::draw_over(const Camera& camera, const Grid& grid,
                          std::span<const PlacedTree> in_view, const PaintOptions& options,
                          Painting& painting) {
  if (options.free.empty() && !options.overlay.any()) return {};
  const auto other_depth = [&](const PlacedFree& placed) {
    return placed.cells->depth() != options.free.front().cells->depth();
  };
  if (std::any_of(options.free.begin(), options.free.end(), other_depth)) {
    return fail(ErrorCode::kInvalid, "free space of several depths in one picture");
  }
  if (auto made = make(overlay_); !made) return made;
  std::vector<TileKey> boxes;
  for (const PlacedTree& placed : in_view) boxes.push_back(placed.key);
  return overlay_->draw(camera, grid, {boxes, options.free}, options.overlay, painting.cells,
                        painting.image);
}

}  // namespace voxatlas
