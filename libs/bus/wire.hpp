#pragma once

#include <fmt/format.h>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "voxatlas/ack_t.hpp"
#include "voxatlas/camera_t.hpp"
#include "voxatlas/chunk_t.hpp"
#include "voxatlas/counter_t.hpp"
#include "voxatlas/frame_t.hpp"
#include "voxatlas/model_reply_t.hpp"
#include "voxatlas/model_request_t.hpp"
#include "voxatlas/render_request_t.hpp"
#include "voxatlas/scan_delta_t.hpp"
#include "voxatlas/scan_t.hpp"
#include "voxatlas/status_t.hpp"
#include "voxatlas/tile_encoded_t.hpp"
#include "voxatlas/tile_raw_t.hpp"
#include "voxatlas/tile_reply_t.hpp"
#include "voxatlas/tile_request_t.hpp"
#include "voxatlas/tile_update_t.hpp"
#include "voxatlas/tiles_reply_t.hpp"
#include "voxatlas/tiles_request_t.hpp"

namespace voxatlas {

/// The generated types live in this namespace too; a name that ends in _t is a message.

/// Checks bytes against a type's shape before the generated decoder sees them, because that throws,
/// or allocates gigabytes, on hostile lengths. One letter a field, in order, after the 8-byte
/// fingerprint: 1 2 4 8 (integers and doubles of that many bytes), s (string), n (the int32 length
/// of what follows), b (that many bytes), C (that many counter_t).
/// Errors: kCorrupt, saying at which byte.
Status check_shape(const char* shape, ByteView bytes);

/// A type's shape; specialised for every type in wire.cpp's table.
template <class T>
const char* shape_of();

/// Whether a message's fields agree with one another (a count with its size, a part with its
/// parts); specialised for every type in wire_fields.cpp. What a value means is its user's to
/// check. Errors: kCorrupt, naming the fields and their values.
template <class T>
Status check_fields(const T& message);

template <class T>
Bytes encode_message(const T& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Errors: kCorrupt for bytes that are not exactly one message of this type, or whose fields
/// contradict
///         one another (a count that does not fit its size). Never throws, never allocates more
///         than the input justifies.
template <class T>
Result<T> decode_message(ByteView bytes) {
  if (auto shape = check_shape(shape_of<T>(), bytes); !shape) {
    return pass_on(shape, T::getTypeName());
  }
  T message{};
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) !=
      static_cast<int>(bytes.size())) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{}: another type's fingerprint", T::getTypeName()));
  }
  if (auto fields = check_fields(message); !fields) return pass_on(fields, T::getTypeName());
  return message;
}

}  // namespace voxatlas
