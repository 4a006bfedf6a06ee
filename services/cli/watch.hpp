#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct WatchOptions {
  std::string url;
  std::int64_t count = 0;        ///< Ends after so many messages; 0: never.
  std::string out;               ///< Frames: folder for their pictures; empty: none are kept.
  std::string only;              ///< Status: of this service alone, "render 0"; empty: of all.
  bool blocks = false;           ///< Frames: show them in the terminal, as coloured blocks.
  std::int64_t until_ready = 0;  ///< Status: ends when so many services are ready; 0: never.
  double timeout = 0;            ///< Seconds, then it is an error; 0: none.
  bool json = false;             ///< One JSON object a line.

  // Of tiles:
  std::string box;      ///< parse_box's text: only tiles that touch it; empty: all.
  std::string around;   ///< parse_place's text: the same, a cube about it,
  double radius = 50;   ///< half its edge in metres.
  bool follow = false;  ///< Keep a copy of the tiles and say when it is in step.
  int depth = 7;        ///< Of that copy.
  std::string hashes;   ///< File for the copy's keys, versions, hashes, written when in step.
  double quiet = 0;     ///< End in step when nothing came for so many seconds; 0: never.
};

/// Print what is published, a line each, until a signal, `count` or `timeout`.
/// Errors: kUnavailable where the time was over first; kIo for files.
Status watch_frames(const WatchOptions& options);
Status watch_tiles(const WatchOptions& options);
/// A table that is drawn anew on a terminal; lines elsewhere.
Status watch_status(const WatchOptions& options);

}  // namespace voxatlas
