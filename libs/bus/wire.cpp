#include "bus/wire.hpp"

#include <cstring>

#include "bus/checkpoint_wire.hpp"

namespace voxatlas {
namespace {

/// Walks a message by its shape, never past its end.
class ShapeWalk {
 public:
  explicit ShapeWalk(ByteView bytes) : bytes_(bytes) {}

  Status field(char letter) {
    switch (letter) {
      case '1':
      case '2':
      case '4':
      case '8':
        return skip(static_cast<std::size_t>(letter - '0'));
      case 's':
        return string();
      case 'n':
        return length();
      case 'b':
        return skip(length_);
      default:
        return counters();
    }
  }

  Status skip(std::size_t count) {
    if (count > bytes_.size() - at_) {
      return fail(ErrorCode::kCorrupt, fmt::format("{} bytes wanted at byte {}, {} left", count,
                                                   at_, bytes_.size() - at_));
    }
    at_ += count;
    return {};
  }

  Status end() const {
    if (at_ == bytes_.size()) return {};
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} bytes too many after byte {}", bytes_.size() - at_, at_));
  }

 private:
  /// LCM's integers are big endian.
  std::int32_t int32_at(std::size_t at) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | bytes_[at + i];
    return static_cast<std::int32_t>(value);
  }

  Status length() {
    const auto at = at_;
    if (auto four = skip(4); !four) return four;
    const auto value = int32_at(at);
    if (value < 0) {
      return fail(ErrorCode::kCorrupt, fmt::format("negative length {} at byte {}", value, at));
    }
    length_ = static_cast<std::size_t>(value);
    return {};
  }

  /// A length that counts the terminating zero, the text, the zero.
  Status string() {
    const auto at = at_;
    if (auto size = length(); !size) return size;
    if (length_ == 0) {
      return fail(ErrorCode::kCorrupt, fmt::format("string of length 0 at byte {}", at));
    }
    if (auto text = skip(length_); !text) return text;
    const auto* text_begin = bytes_.data() + (at_ - length_);
    if (std::memchr(text_begin, 0, length_) != text_begin + length_ - 1) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("string at byte {} does not end at its first zero", at));
    }
    return {};
  }

  Status counters() {
    constexpr std::size_t kLeastBytes = 4 + 1 + 8;  // The name's length, its zero, the value.
    const auto count = length_;
    if (count > (bytes_.size() - at_) / kLeastBytes) {
      return fail(ErrorCode::kCorrupt,
                  fmt::format("{} counters announced at byte {}, {} bytes left", count, at_,
                              bytes_.size() - at_));
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (auto name = string(); !name) return name;
      if (auto value = skip(8); !value) return value;
    }
    return {};
  }

  ByteView bytes_;
  std::size_t at_ = 0;
  std::size_t length_ = 0;  ///< Of what follows, from the last n.
};

constexpr std::size_t kFingerprintBytes = 8;

}  // namespace

Status check_shape(const char* shape, ByteView bytes) {
  ShapeWalk walk(bytes);
  if (auto fingerprint = walk.skip(kFingerprintBytes); !fingerprint) return fingerprint;
  for (const char* letter = shape; *letter != 0; ++letter) {
    if (auto field = walk.field(*letter); !field) return field;
  }
  return walk.end();
}

#define VOX_CAMERA_SHAPE \
  "188888888888"         \
  "44"                   \
  "88"

// clang-format off
template <> const char* shape_of<ack_t>() { return "8888844nb"; }
template <> const char* shape_of<camera_t>() { return VOX_CAMERA_SHAPE; }
template <> const char* shape_of<checkpoint_reply_t>() { return "8884ss"; }
template <> const char* shape_of<checkpoint_request_t>() { return "888844"; }
template <> const char* shape_of<chunk_t>() { return "888884424nb"; }
template <> const char* shape_of<counter_t>() { return "s8"; }
template <> const char* shape_of<frame_t>() {
  return "8884" "8411s" VOX_CAMERA_SHAPE "181448884" "888888" "11nb" "18nb";
}
template <> const char* shape_of<model_reply_t>() { return "8884888" "8nb"; }
template <> const char* shape_of<model_request_t>() { return "888844s818"; }
template <> const char* shape_of<render_request_t>() {
  return "88881" VOX_CAMERA_SHAPE "84nb" "81s111" "1114";
}
template <> const char* shape_of<scan_delta_t>() { return "8s88884" "44nb"; }
template <> const char* shape_of<scan_t>() { return "8s882288" "888888888888" "14nb"; }
template <> const char* shape_of<status_t>() { return "8s484s1snC"; }
template <> const char* shape_of<tile_encoded_t>() { return "888nb"; }
template <> const char* shape_of<tile_raw_t>() { return "888422nb"; }
template <> const char* shape_of<tile_reply_t>() { return "8888844nb"; }
template <> const char* shape_of<tile_request_t>() { return "888844841"; }
template <> const char* shape_of<tile_update_t>() { return "88841nb"; }
template <> const char* shape_of<tiles_reply_t>() { return "888481" "4nb"; }
template <> const char* shape_of<tiles_request_t>() { return "8888448" "444444" "1"; }
// clang-format on

#undef VOX_CAMERA_SHAPE

}  // namespace voxatlas
