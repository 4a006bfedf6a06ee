#include "render/gl_context.hpp"

#include <GL/gl.h>
#include <GL/osmesa.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>
#include <utility>

namespace voxatlas {
namespace {

/// Mesa crashes on a driver's name it does not know, so the environment must not give one.
void forget_driver_choice() {
  static std::once_flag once;
  std::call_once(once, [] { unsetenv("GALLIUM_DRIVER"); });
}

/// GL's rows begin at the bottom.
void turn_over(std::vector<std::uint32_t>& pixels, int width, int height) {
  for (int y = 0; y < height / 2; ++y) {
    const auto upper = pixels.begin() + std::ptrdiff_t{y} * width;
    const auto lower = pixels.begin() + std::ptrdiff_t{height - 1 - y} * width;
    std::swap_ranges(upper, upper + width, lower);
  }
}

}  // namespace

struct GlContext::State {
  OSMesaContext context = nullptr;
  std::vector<std::uint32_t> buffer;  // Mesa's own front buffer; must live while it is current.
  int width = 0;
  int height = 0;

  ~State() {
    if (context != nullptr) OSMesaDestroyContext(context);
  }
};

Result<std::unique_ptr<GlContext>> GlContext::create() {
  forget_driver_choice();
  constexpr std::array kAttributes = {
      OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 32, OSMESA_PROFILE, OSMESA_COMPAT_PROFILE, 0};
  auto state = std::make_unique<State>();
  state->context = OSMesaCreateContextAttribs(kAttributes.data(), nullptr);
  if (state->context == nullptr) {
    return fail(ErrorCode::kUnavailable, "OSMesa makes no OpenGL context");
  }
  return std::unique_ptr<GlContext>(new GlContext(std::move(state)));
}

GlContext::GlContext(std::unique_ptr<State> state) : state_(std::move(state)) {}
GlContext::~GlContext() = default;

Status GlContext::begin(int width, int height) {
  constexpr int kMaxSide = 16384;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("GL draws no picture of {} x {} pixels", width, height));
  }
  State& state = *state_;
  state.width = width;
  state.height = height;
  state.buffer.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (OSMesaMakeCurrent(state.context, state.buffer.data(), GL_UNSIGNED_BYTE, width, height) ==
      GL_FALSE) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("OSMesa draws no picture of {} x {} pixels", width, height));
  }
  while (glGetError() != GL_NO_ERROR) {  // Of an earlier picture.
  }
  glViewport(0, 0, width, height);
  glDisable(GL_DITHER);  // A cell's number is its colour: every bit counts.
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);
  glClearDepth(1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  return {};
}

Status GlContext::finish(Pixels& pixels) {
  const State& state = *state_;
  pixels.colour.resize(state.buffer.size());
  pixels.depth.resize(state.buffer.size());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, state.width, state.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.colour.data());
  glReadPixels(0, 0, state.width, state.height, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT,
               pixels.depth.data());
  turn_over(pixels.colour, state.width, state.height);
  turn_over(pixels.depth, state.width, state.height);
  if (const auto error = glGetError(); error != GL_NO_ERROR) {
    return fail(ErrorCode::kIo, fmt::format("GL error {:#x} while drawing", error));
  }
  return {};
}

}  // namespace voxatlas
