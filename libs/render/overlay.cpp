#define GL_GLEXT_PROTOTYPES
#include "render/overlay.hpp"

#include <GL/gl.h>
#include <GL/glext.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/gl_view.hpp"
#include "render/signs.hpp"

namespace voxatlas {
namespace {

constexpr std::array<GLubyte, 4> kFreeFace = {150, 156, 166, 44};
constexpr std::array<GLubyte, 4> kFreeEdge = {150, 156, 166, 110};
constexpr std::array<GLubyte, 4> kBox = {20, 52, 150, 255};

/// The picture's rows, the last first, as GL wants them.
template <class Out, class Of>
std::vector<Out> from_below(int width, int height, const Of& of) {
  std::vector<Out> rows;
  rows.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) rows.push_back(of(x, y));
  }
  return rows;
}

/// Makes the picture, and how far it is, what the rest is drawn over.
void upload(const Image& image, const CellImage& cells, const Lens& lens) {
  const auto colours = from_below<std::uint32_t>(image.width, image.height, [&](int x, int y) {
    const Rgb pixel = image.at(x, y);
    return 0xff000000u | std::uint32_t{pixel.b} << 16 | std::uint32_t{pixel.g} << 8 | pixel.r;
  });
  const auto depths = from_below<float>(image.width, image.height, [&](int x, int y) {
    const auto z = static_cast<double>(cells.z[cells.index(x, y)]);
    return std::isfinite(z) ? static_cast<float>(std::clamp(gl_depth_of(z, lens), 0.0, 1.0)) : 1.0f;
  });
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_ALWAYS);
  glWindowPos2i(0, 0);
  glDrawPixels(image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, colours.data());
  glDepthMask(GL_TRUE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glWindowPos2i(0, 0);
  glDrawPixels(image.width, image.height, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
}

void look_at_tile(const Camera& camera, const Grid& grid, TileKey key) {
  glMatrixMode(GL_MODELVIEW);
  glLoadMatrixd(camera_from_tile(camera, grid, key, 1).data());
}

void add_face(const FreeFace& face, int voxels) {
  constexpr std::array<std::array<int, 2>, 4> kRound = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  for (const auto& [u, v] : kRound) {
    Eigen::Vector3i at = face.cell;
    at[face.axis] += face.upper ? 1 : 0;
    at[(face.axis + 1) % 3] += u;
    at[(face.axis + 2) % 3] += v;
    at *= voxels;
    glVertex3i(at.x(), at.y(), at.z());
  }
}

void draw_free(const Camera& camera, const Grid& grid, std::span<const PlacedFree> free) {
  const auto faces = bounding_faces(free);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1, 1);  // Behind a cell's face that lies in the same plane.
  for (const bool edges : {false, true}) {
    glPolygonMode(GL_FRONT_AND_BACK, edges ? GL_LINE : GL_FILL);
    glColor4ubv(edges ? kFreeEdge.data() : kFreeFace.data());
    for (std::size_t i = 0; i < free.size(); ++i) {
      look_at_tile(camera, grid, free[i].key);
      glBegin(GL_QUADS);
      for (const FreeFace& face : faces[i]) add_face(face, kTileVoxels / free[i].cells->edge());
      glEnd();
    }
  }
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void draw_boxes(const Camera& camera, const Grid& grid, std::span<const TileKey> boxes) {
  glLineWidth(1.5f);
  glColor4ubv(kBox.data());
  for (const TileKey key : boxes) {
    look_at_tile(camera, grid, key);
    glBegin(GL_LINES);
    for (int corner = 0; corner < 8; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        if ((corner >> axis & 1) != 0) continue;
        for (const int end : {corner, corner | 1 << axis}) {
          glVertex3i((end & 1) * kTileVoxels, (end >> 1 & 1) * kTileVoxels,
                     (end >> 2) * kTileVoxels);
        }
      }
    }
    glEnd();
  }
}

/// Over everything, with a light rim, so that they show on any ground.
void draw_strokes(const Strokes& strokes, int width, int height) {
  glDisable(GL_DEPTH_TEST);
  glMatrixMode(GL_PROJECTION);
  glLoadIdentity();
  glOrtho(0, width, height, 0, -1, 1);
  glMatrixMode(GL_MODELVIEW);
  glLoadIdentity();
  for (const bool rim : {true, false}) {
    glLineWidth(rim ? 4.5f : 1.8f);
    glBegin(GL_LINES);
    for (const Stroke& stroke : strokes) {
      rim ? glColor4ub(255, 255, 255, 150)
          : glColor4ub(stroke.colour.r, stroke.colour.g, stroke.colour.b, 255);
      glVertex2fv(stroke.from.data());
      glVertex2fv(stroke.to.data());
    }
    glEnd();
  }
}

Strokes strokes_of(const Camera& camera, const OverlayOptions& options, const CellImage& cells) {
  Strokes all;
  const auto add = [&all](const Strokes& some) { all.insert(all.end(), some.begin(), some.end()); };
  if (options.axes) add(axes_sign(camera));
  if (options.north) add(north_sign(camera));
  if (options.scale) add(scale_sign(camera, cells));
  return all;
}

void download(const GlContext::Pixels& pixels, Image& image) {
  std::transform(pixels.colour.begin(), pixels.colour.end(), image.pixels.begin(),
                 [](std::uint32_t c) {
                   return Rgb{static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(c >> 8),
                              static_cast<std::uint8_t>(c >> 16)};
                 });
}

}  // namespace

Result<std::unique_ptr<Overlay>> Overlay::create() {
  auto context = GlContext::create();
  if (!context) return pass_on(context);
  return std::unique_ptr<Overlay>(new Overlay(std::move(*context)));
}

Status Overlay::draw(const Camera& camera, const Grid& grid, const OverlayScene& scene,
                     const OverlayOptions& options, const CellImage& cells, Image& image) {
  if (scene.free.empty() && !options.any()) return {};
  if (auto begun = context_->begin(image.width, image.height); !begun) return begun;
  upload(image, cells, camera.lens());
  glMatrixMode(GL_PROJECTION);
  glLoadMatrixd(gl_projection(camera.lens(), 0).data());
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  if (!scene.free.empty()) draw_free(camera, grid, scene.free);
  glEnable(GL_LINE_SMOOTH);
  if (options.tile_boxes) draw_boxes(camera, grid, scene.boxes);
  draw_strokes(strokes_of(camera, options, cells), image.width, image.height);
  glDisable(GL_LINE_SMOOTH);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);  // begin() clears through it.
  if (auto finished = context_->finish(pixels_); !finished) return finished;
  download(pixels_, image);
  return {};
}

}  // namespace voxatlas
