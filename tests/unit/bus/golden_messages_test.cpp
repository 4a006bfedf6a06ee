// Messages that earlier versions sent are read for ever: a type never changes, since LCM's
// fingerprint would make it another; a new version of one is a new type (lcmtypes/README.md).
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "bus/random_messages.hpp"

namespace voxatlas {
namespace {

#define VOX_TYPES_OF_VERSION_1                                                                \
  ack_t, camera_t, checkpoint_reply_t, checkpoint_request_t, chunk_t, counter_t, frame_t,     \
      model_reply_t, model_request_t, render_request_t, scan_delta_t, scan_t, status_t,       \
      tile_encoded_t, tile_raw_t, tile_reply_t, tile_request_t, tile_update_t, tiles_reply_t, \
      tiles_request_t

template <class T>
std::string golden_path() {
  return std::string(VOX_TEST_DATA "/messages/") + T::getTypeName() + ".bin";
}

template <class T>
Bytes read_golden() {
  std::ifstream file(golden_path<T>(), std::ios::binary);
  INFO(golden_path<T>());
  REQUIRE(file.good());
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

TEMPLATE_TEST_CASE("a message of version 1 is read for ever, field by field", "[bus][golden]",
                   VOX_TYPES_OF_VERSION_1) {
  const auto golden = read_golden<TestType>();
  const auto message = decode_message<TestType>(golden);
  if (!message) FAIL(message.error().message);
  REQUIRE(encode_message(*message) == golden);
}

TEMPLATE_TEST_CASE("a message of a newer version is refused, and named", "[bus][golden]",
                   VOX_TYPES_OF_VERSION_1) {
  auto newer = read_golden<TestType>();
  newer[7] = static_cast<std::uint8_t>(newer[7] + 1);  // Its fingerprint, which holds every field.
  const auto message = decode_message<TestType>(newer);
  REQUIRE_FALSE(message.has_value());
  REQUIRE_THAT(message.error().message, Catch::Contains(TestType::getTypeName()));
}

// For a new type only: unit_bus "[.write-golden]" writes the files that are not there.
TEMPLATE_TEST_CASE("golden messages are written", "[.write-golden]", VOX_TYPES_OF_VERSION_1) {
  if (std::ifstream(golden_path<TestType>()).good()) return;
  std::mt19937_64 rng(1);
  const auto bytes = encode_message(test::RandomMessages(rng).make<TestType>());
  std::ofstream(golden_path<TestType>(), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

}  // namespace
}  // namespace voxatlas
