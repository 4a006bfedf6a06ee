#pragma once

namespace voxatlas {

/// Every plain channel: its name, and in the comment its type, from whom, to whom. The reliable
/// ones are made of an Endpoint. The protocol, message by message, is in lcmtypes/README.md.
inline constexpr const char* kScanChannel = "VOXATLAS_SCAN";  // scan_t: loggers -> ingest
inline constexpr const char* kAckChannel = "VOXATLAS_ACK";    // ack_t: consumers -> producers
inline constexpr const char* kTileUpdateChannel =
    "VOXATLAS_TILE_UPDATE";  // tile_update_t: tilestore -> anyone
inline constexpr const char* kFrameChannel = "VOXATLAS_FRAME";    // frame_t: render -> anyone
inline constexpr const char* kStatusChannel = "VOXATLAS_STATUS";  // status_t: services -> anyone
inline constexpr const char* kRenderRequestChannel =
    "VOXATLAS_RENDER_REQUEST";  // render_request_t: anyone -> render
inline constexpr const char* kModelRequestChannel =
    "VOXATLAS_MODEL_REQUEST";  // model_request_t: anyone -> tilestore
inline constexpr const char* kModelReplyChannel =
    "VOXATLAS_MODEL_REPLY";  // model_reply_t: tilestore -> who asked, at its port
inline constexpr const char* kTilesRequestChannel =
    "VOXATLAS_TILES_REQUEST";  // tiles_request_t: anyone -> tilestore
inline constexpr const char* kTilesReplyChannel =
    "VOXATLAS_TILES_REPLY";  // tiles_reply_t: tilestore -> who asked, at its port
inline constexpr const char* kTileRequestChannel =
    "VOXATLAS_TILE_REQUEST";  // tile_request_t: anyone -> tilestore
inline constexpr const char* kTileReplyChannel =
    "VOXATLAS_TILE_REPLY";  // tile_reply_t: tilestore -> who asked, at its port

}  // namespace voxatlas
