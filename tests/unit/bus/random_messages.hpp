#pragma once

#include <random>

#include "bus/ack_ranges.hpp"
#include "bus/checkpoint_wire.hpp"

namespace voxatlas::test {

/// Messages with random fields that agree with one another, of every type.
class RandomMessages {
 public:
  explicit RandomMessages(std::mt19937_64& rng) : rng_(rng) {}

  void fill(ack_t& m);
  void fill(camera_t& m);
  void fill(chunk_t& m);
  void fill(counter_t& m);
  void fill(frame_t& m);
  void fill(checkpoint_reply_t& m);
  void fill(checkpoint_request_t& m);
  void fill(model_reply_t& m);
  void fill(model_request_t& m);
  void fill(render_request_t& m);
  void fill(scan_delta_t& m);
  void fill(scan_t& m);
  void fill(status_t& m);
  void fill(tile_encoded_t& m);
  void fill(tile_raw_t& m);
  void fill(tile_reply_t& m);
  void fill(tile_request_t& m);
  void fill(tile_update_t& m);
  void fill(tiles_reply_t& m);
  void fill(tiles_request_t& m);

  template <class T>
  T make() {
    T message{};
    fill(message);
    return message;
  }

  /// 0 .. most - 1.
  template <class T = std::int32_t>
  T below(std::uint64_t most) {
    return static_cast<T>(rng_() % most);
  }

 private:
  std::int64_t number() { return static_cast<std::int64_t>(rng_() >> 4); }
  std::int32_t small() { return below(1 << 20); }
  double real() { return static_cast<double>(number()) / 1e9 - 1e9; }
  std::string text() {
    return std::string(below<std::size_t>(20), static_cast<char>('a' + small() % 26));
  }
  std::string source() { return text() + 's'; }
  Bytes blob(std::size_t size);
  template <class T>
  void payload(std::int32_t& size, T& bytes, std::size_t most = 300) {
    bytes = blob(below<std::size_t>(most));
    size = static_cast<std::int32_t>(bytes.size());
  }

  std::mt19937_64& rng_;
};

}  // namespace voxatlas::test
