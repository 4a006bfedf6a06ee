#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "render/camera_path.hpp"
#include "render/pacer.hpp"
#include "render/paint_job.hpp"

namespace voxatlas {

struct QuestionLimits {
  std::size_t jpeg_bytes = 150'000;                  ///< Of a broadcast frame's picture.
  std::size_t stream_bytes = std::size_t{60} << 20;  ///< What a reliable stream's consumer takes.
};

/// A render_request_t that was found good: what is asked for.
struct Question {
  std::int64_t client = 0, id = 0;
  std::int64_t deadline = 0;  ///< utime; 0: none.
  bool stream = false;
  std::int64_t gap_us = 0;  ///< Between the pictures of a stream.
  double rate = 0;
  std::int32_t first = 0;          ///< Of a path: the first place wanted.
  std::optional<CameraPath> path;  ///< Else the camera rests.
  Camera camera;                   ///< The first.
  Pace pace;
  PaintOptions how;
  int free_depth = 0;  ///< Of the free cells drawn; 0: none are.
  EncodeOptions encode;
  std::int32_t reply_port = 0;

  /// Every picture is the whole one, whatever it takes: without a budget, unless it would come too
  /// late for everyone who watches.
  bool exact() const { return !(pace.budget_ms > 0) && (!stream || (path && reply_port != 0)); }

  /// Errors: kOutOfRange, kInvalid, naming the field and its value.
  static Result<Question> create(const render_request_t& request, const QuestionLimits& limits,
                                 std::int64_t utime);
};

/// Where the answer goes: a client's port where the request names one, else everyone (0).
std::int32_t way_back(const render_request_t& request);

}  // namespace voxatlas
