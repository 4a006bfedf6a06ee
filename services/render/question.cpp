#include "render/question.hpp"

#include <fmt/format.h>

#include <utility>

#include "bus/endpoint.hpp"
#include "render/camera_message.hpp"

namespace voxatlas {
namespace {

constexpr double kMaxRate = 60;
constexpr std::int64_t kMaxStreamUs = std::int64_t{3600} * 1'000'000;

template <class... Args>
tl::unexpected<Error> refuse(fmt::format_string<Args...> format, Args&&... args) {
  return fail(ErrorCode::kOutOfRange, fmt::format(format, std::forward<Args>(args)...));
}

Status check_formats(const render_request_t& request) {
  if (request.format < 0 || request.format > 2) {
    return refuse("format {} is not 0 (JPEG), 1 (PNG) or 2 (raw RGB)", request.format);
  }
  if (request.depth_format < 0 || request.depth_format > 2) {
    return refuse("depth_format {} is not 0 (none), 1 (uint16) or 2 (float32)",
                  request.depth_format);
  }
  if (request.reply_port != 0) {
    auto port = Endpoint::client_at(request.reply_port);
    return port ? Status{} : pass_on(port, "reply_port");
  }
  if (request.format != 0 || request.depth_format != 0) {
    return refuse("format {} with depth_format {} goes by reliable stream only: reply_port is 0",
                  request.format, request.depth_format);
  }
  return {};
}

Status check_stream(const render_request_t& request, std::int64_t utime) {
  if (request.kind == 0) {
    if (request.path_size == 0) return {};
    return refuse("kind 0 is one picture, but path has {} bytes: ask for a stream (1)",
                  request.path_size);
  }
  if (request.kind != 1) {
    return refuse("kind {} is not 0 (picture), 1 (stream) or 2 (cancel)", request.kind);
  }
  if (!(request.rate > 0 && request.rate <= kMaxRate)) {
    return refuse("a rate of {} pictures a second is not above 0 and at most {}", request.rate,
                  kMaxRate);
  }
  if (request.path_size == 0 &&
      (request.deadline == 0 || request.deadline > utime + kMaxStreamUs)) {
    return refuse("a stream of a camera that rests needs a deadline, at most an hour ahead: {}",
                  request.deadline);
  }
  return {};
}

Status check_drawing(const render_request_t& request) {
  if (request.backend != 0 && request.backend != 1) {
    return refuse("backend {} is neither 0 (splatter) nor 1 (OpenGL's points)", request.backend);
  }
  if (request.backend == 1 && (request.kind != 0 || request.budget_ms > 0)) {
    return refuse("backend 1 draws one picture without budget: kind {}, budget_ms {}", request.kind,
                  request.budget_ms);
  }
  if (request.overlay < 0 || request.overlay > 15) {
    return refuse("overlay {} is not a sum of 1 (tile boxes), 2 (axes), 4 (north), 8 (scale)",
                  request.overlay);
  }
  if (request.free_depth < 0 || request.free_depth > kDepth) {
    return refuse("free_depth {} is not within 0..{}", request.free_depth, kDepth);
  }
  if (request.fill_holes != 0 && request.fill_holes != 1) {
    return refuse("fill_holes {} is neither 0 nor 1", request.fill_holes);
  }
  return {};
}

PaintOptions how_of(const render_request_t& request, Colouring colouring) {
  PaintOptions how;
  how.colouring = colouring;
  how.fill_holes = request.fill_holes == 1;
  how.backend = request.backend == 1 ? Backend::kGl : Backend::kSplat;
  how.overlay.tile_boxes = (request.overlay & 1) != 0;
  how.overlay.axes = (request.overlay & 2) != 0;
  how.overlay.north = (request.overlay & 4) != 0;
  how.overlay.scale = (request.overlay & 8) != 0;
  return how;
}

Pace pace_of(const render_request_t& request, const Camera& camera) {
  Pace pace;
  pace.budget_ms = request.budget_ms;
  pace.depth = request.depth;
  pace.pixels = std::int64_t{camera.width()} * camera.height();
  // A depth image is of one ray a pixel, and along a path there is no time for more.
  pace.supersample = request.budget_ms > 0 && request.depth_format == 0 && request.path_size == 0;
  return pace;
}

}  // namespace

std::int32_t way_back(const render_request_t& request) {
  return Endpoint::client_at(request.reply_port) ? request.reply_port : 0;
}

Result<Question> Question::create(const render_request_t& request, const QuestionLimits& limits,
                                  std::int64_t utime) {
  if (auto good = check_formats(request); !good) return pass_on(good);
  if (auto good = check_stream(request, utime); !good) return pass_on(good);
  if (auto good = check_drawing(request); !good) return pass_on(good);
  auto colouring = colouring_of(request.colouring);
  if (!colouring) return pass_on(colouring);
  std::optional<CameraPath> path;
  auto camera = to_camera(request.camera);
  if (request.path_size > 0) {
    auto made = CameraPath::create(request.path, lens_of(request.camera));
    if (!made) return pass_on(made);
    if (request.first < 0 || request.first >= made->places(request.rate)) {
      return refuse("first {} is not one of the path's {} places", request.first,
                    made->places(request.rate));
    }
    camera = made->at(request.first / request.rate);
    path = std::move(*made);
  }
  if (!camera) return pass_on(camera);
  const Pace pace = pace_of(request, *camera);
  if (auto good = Pacer().begin(pace); !good) return pass_on(good);
  Question question{request.client,
                    request.id,
                    request.deadline,
                    request.kind == 1,
                    0,
                    request.rate,
                    request.first,
                    std::move(path),
                    *camera,
                    pace,
                    {},
                    request.free_depth,
                    {},
                    request.reply_port};
  question.how = how_of(request, *colouring);
  if (question.stream) question.gap_us = static_cast<std::int64_t>(1e6 / request.rate);
  question.encode.format = static_cast<PictureFormat>(request.format);
  question.encode.depth = static_cast<DepthFormat>(request.depth_format);
  question.encode.most_bytes = request.reply_port == 0 ? limits.jpeg_bytes : limits.stream_bytes;
  return question;
}

}  // namespace voxatlas
