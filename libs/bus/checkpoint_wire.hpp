#pragma once

#include "bus/wire.hpp"
#include "voxatlas/checkpoint_reply_t.hpp"
#include "voxatlas/checkpoint_request_t.hpp"

namespace voxatlas {

/// The messages of a copy that a tile store makes of itself. Beside wire.hpp and channels.hpp, as
/// the command line and the tile store alone need them.
inline constexpr const char* kCheckpointRequestChannel =
    "VOXATLAS_CHECKPOINT_REQUEST";  // checkpoint_request_t: anyone -> tilestore
inline constexpr const char* kCheckpointReplyChannel =
    "VOXATLAS_CHECKPOINT_REPLY";  // checkpoint_reply_t: tilestore -> who asked, at its port

}  // namespace voxatlas
