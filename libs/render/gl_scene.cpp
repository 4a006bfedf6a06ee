#define GL_GLEXT_PROTOTYPES
#include "render/gl_scene.hpp"

#include <GL/gl.h>
#include <GL/glext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "render/gl_view.hpp"

namespace voxatlas {
namespace {

/// Pixels drawn around the picture, for points whose middle lies outside it.
constexpr int kMargin = static_cast<int>(GlScene::kMaxPoint / 2) + 1;

/// z of the corner of a tile that lies least far ahead.
double nearest_z(const Eigen::Matrix4d& m) {
  double z = m(2, 3);
  for (int axis = 0; axis < 3; ++axis) z += std::min(0.0, m(2, axis) * 2 * kTileVoxels);
  return z;
}

/// Nearer than this, cells of an edge are drawn as cubes.
double cube_range(const Lens& lens, double edge) {
  const double too_large =
      GlScene::kSplatScale * edge * std::max(lens.fx, lens.fy) / GlScene::kMaxPoint;
  if (lens.projection == Projection::kOrthographic) {
    return too_large > 1 ? lens.far_range : lens.near_range + edge * std::numbers::sqrt3 / 2;
  }
  return std::max(too_large, lens.near_range + edge * std::numbers::sqrt3 / 2);
}

/// GL derives a point's size from its z: size = 1 / sqrt(c z^2), of a map 1 / sqrt(c), held within
/// the limits.
void set_point_size(const Lens& lens, double edge) {
  const double at_one_metre = GlScene::kSplatScale * edge * std::max(lens.fx, lens.fy);
  const auto by_square = static_cast<float>(1 / (at_one_metre * at_one_metre));
  const bool map = lens.projection == Projection::kOrthographic;
  const std::array attenuation = {map ? by_square : 0.0f, 0.0f, map ? 0.0f : by_square};
  glEnable(GL_POINT_SPRITE);  // Squares of any size; other points have whole pixels, cut down.
  glPointSize(1);
  glPointParameterfv(GL_POINT_DISTANCE_ATTENUATION, attenuation.data());
  glPointParameterf(GL_POINT_SIZE_MIN, static_cast<float>(GlScene::kMinPoint));
  glPointParameterf(GL_POINT_SIZE_MAX, static_cast<float>(GlScene::kMaxPoint));
}

/// The six faces of a cell, in half voxels.
void draw_cube(const DrawnCell& cell, std::uint32_t number) {
  // A corner's bits say on which side of each axis it lies.
  constexpr std::array<int, 24> kFaces = {0, 2, 6, 4, 1, 5, 7, 3, 0, 4, 5, 1,
                                          2, 3, 7, 6, 0, 1, 3, 2, 4, 6, 7, 5};
  const int half = 1 << (kDepth - cell.depth);
  glColor4ubv(reinterpret_cast<const GLubyte*>(&number));
  for (const int corner : kFaces) {
    const auto side = [&](int axis) {
      const int sign = (corner >> axis & 1) != 0 ? 1 : -1;
      return static_cast<GLshort>(cell.centre[static_cast<std::size_t>(axis)] + sign * half);
    };
    glVertex3s(side(0), side(1), side(2));
  }
}

/// Which cells of a tile lie nearer than the range where points end, and which beyond.
struct NearAndFar {
  std::vector<GLuint> near_cells, far_cells;

  NearAndFar(const Eigen::Matrix4d& m, std::span<const DrawnCell> cells, double range) {
    const Eigen::RowVector3d ahead = m.row(2).head<3>();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto& c = cells[i].centre;
      const double z = ahead.dot(Eigen::RowVector3d(c[0], c[1], c[2])) + m(2, 3);
      (z < range ? near_cells : far_cells).push_back(static_cast<GLuint>(i));
    }
  }
};

/// The picture without its margin.
CellImage cut_out(const GlContext::Pixels& pixels, const Lens& lens) {
  CellImage image;
  image.width = lens.width;
  image.height = lens.height;
  const auto count = static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
  image.cell.resize(count);
  image.z.assign(count, CellImage::kNowhere);
  const auto stride = static_cast<std::size_t>(lens.width + 2 * kMargin);
  for (int y = 0; y < lens.height; ++y) {
    const std::size_t from = static_cast<std::size_t>(y + kMargin) * stride + kMargin;
    for (int x = 0; x < lens.width; ++x) {
      const std::size_t to = image.index(x, y);
      const std::size_t at = from + static_cast<std::size_t>(x);
      image.cell[to] = pixels.colour[at];
      if (image.cell[to] != CellImage::kNone) {
        image.z[to] = static_cast<float>(metres_of_gl_depth(pixels.depth[at] / 4294967295.0, lens));
      }
    }
  }
  return image;
}

}  // namespace

Result<std::unique_ptr<GlScene>> GlScene::create() {
  auto context = GlContext::create();
  if (!context) return pass_on(context);
  return std::unique_ptr<GlScene>(new GlScene(std::move(*context)));
}

void GlScene::number_up_to(std::uint64_t count) {
  while (numbers_.size() <= count) numbers_.push_back(static_cast<std::uint32_t>(numbers_.size()));
}

Result<CellImage> GlScene::draw(const Camera& camera, const Grid& grid,
                                std::span<const PlacedCloud> clouds) {
  const CellNumbers numbers(clouds);
  if (!numbers.fits()) {
    return fail(
        ErrorCode::kOutOfRange,
        fmt::format("a picture of {} cells: more than 32 bits can number", numbers.count()));
  }
  number_up_to(numbers.count());
  const Lens& lens = camera.lens();
  if (auto begun = context_->begin(lens.width + 2 * kMargin, lens.height + 2 * kMargin); !begun) {
    return pass_on(begun);
  }
  glMatrixMode(GL_PROJECTION);
  glLoadMatrixd(gl_projection(lens, kMargin).data());
  glMatrixMode(GL_MODELVIEW);
  glEnableClientState(GL_VERTEX_ARRAY);
  glEnableClientState(GL_COLOR_ARRAY);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    draw_cloud(camera, grid, clouds[i], numbers.first_of(i));
  }
  if (auto finished = context_->finish(pixels_); !finished) return pass_on(finished);
  return cut_out(pixels_, lens);
}

void GlScene::draw_cloud(const Camera& camera, const Grid& grid, const PlacedCloud& placed,
                         std::uint32_t first_number) {
  const Lens& lens = camera.lens();
  const Eigen::Matrix4d m = camera_from_tile(camera, grid, placed.key, 2);
  glLoadMatrixd(m.data());
  for (int depth = 0; depth <= kDepth; ++depth) {
    const auto cells = placed.cloud->cells_of_depth(depth);
    if (cells.empty()) continue;
    const auto number =
        first_number + static_cast<std::uint32_t>(cells.data() - placed.cloud->cells().data());
    const double edge = grid.cell_length(depth);
    set_point_size(lens, edge);
    glVertexPointer(3, GL_SHORT, sizeof(DrawnCell), cells.data());
    glColorPointer(4, GL_UNSIGNED_BYTE, 0, numbers_.data() + number);
    const double range = cube_range(lens, edge);
    if (nearest_z(m) >= range) {
      glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(cells.size()));
      continue;
    }
    const NearAndFar split(m, cells, range);
    glDrawElements(GL_POINTS, static_cast<GLsizei>(split.far_cells.size()), GL_UNSIGNED_INT,
                   split.far_cells.data());
    glBegin(GL_QUADS);
    for (const GLuint i : split.near_cells) draw_cube(cells[i], number + i);
    glEnd();
  }
}

}  // namespace voxatlas
