#pragma once

#include <cstdint>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct RenderOptions {
  std::string url;
  // Where from: the first of these that is given.
  std::string path;     ///< File of a camera path: a picture each 1/rate seconds, numbered.
  double rate = 25;     ///< Pictures a second of the path.
  int orbit = 0;        ///< So many pictures, numbered, once round what is looked at.
  double map = 0;       ///< A map of so many metres from left to right, north up.
  std::string at;       ///< "LAT,LON,HEIGHT" to stand at (of a map: its middle), looking
  std::string look_at;  ///< at this place, or
  double heading = 0;   ///< level, this way: degrees from north, east is 90.
  std::string view = "oblique";  ///< "street" or "oblique", chosen by what the model holds.
  std::string size = "1280x720";
  double fov = 0;  ///< Degrees from top to bottom; 0: the view's own.

  int depth = 7;
  double budget = 0;  ///< Milliseconds for the first picture; better ones follow. 0: none.
  std::string colouring = "rgb";
  std::string backend = "splat";  ///< Or "gl".
  bool fill_holes = false;
  int free_depth = 0;  ///< Free cells of this depth as translucent grey; 0: none.
  bool boxes = false, axes = false, north = false, scale = false;  ///< Drawn on top.
  std::string out;          ///< File: .jpg, .raw (RGB), else PNG; of a path or orbit the folder.
  std::string depth_image;  ///< File: .u16 (steps), else float32 metres, row by row.
  bool broadcast = false;   ///< As JPEG on VOXATLAS_FRAME, for everyone who watches frames.
  double timeout = 60;      ///< Seconds to wait for a picture.
  bool json = false;
};

/// Asks the render service for a picture, or the pictures along a path, and writes them.
/// Errors: kInvalid for options; kNotFound for a model without anything to see; kUnavailable where
///         a picture does not come; kIo for a file.
Status run_render(const RenderOptions& options);

}  // namespace voxatlas
