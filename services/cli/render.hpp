#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct RenderOptions {
  std::string url;
  std::string view = "oblique";  ///< "street" or "oblique", chosen by what the model holds,
  std::string at;                ///< or "LAT,LON,HEIGHT" to stand at, looking
  double heading = 0;            ///< this way, degrees from north, east is 90.
  std::string size = "1280x720";
  int depth = 7;
  std::string colouring = "rgb";
  std::string out;         ///< PNG file; JPEG where it is broadcast.
  bool broadcast = false;  ///< As a JPEG on VOXATLAS_FRAME, for everyone who watches frames.
  double timeout = 60;     ///< Seconds to wait for the picture.
  bool json = false;
};

/// Asks the render service for one picture and writes it.
/// Errors: kInvalid for options; kNotFound for a model without anything to see; kUnavailable where
/// the
///         picture does not come; kIo for the file.
Status run_render(const RenderOptions& options);

}  // namespace voxatlas
