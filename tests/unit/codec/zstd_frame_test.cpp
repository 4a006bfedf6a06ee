#include "codec/zstd_frame.hpp"

#include <zstd.h>

#include <catch2/catch.hpp>

#include "support/engine.hpp"

namespace voxatlas {
namespace {

Bytes compressed(ByteView content, int level = 3) {
  Bytes frame;
  zstd_compress(content, level, frame);
  return frame;
}

TEST_CASE("a frame gives back its content at every level, and appends", "[codec]") {
  auto rng = test::engine();
  for (int level = 1; level <= 19; ++level) {
    Bytes content(rng() % 5000);
    for (auto& byte : content) byte = static_cast<std::uint8_t>(rng() % 7);
    Bytes out{1, 2, 3};
    zstd_compress(content, level, out);
    REQUIRE(Bytes(out.begin(), out.begin() + 3) == Bytes{1, 2, 3});
    REQUIRE(zstd_decompress(ByteView(out).subspan(3), content.size()).value() == content);
  }
}

TEST_CASE("a frame that is cut, followed or of another size is refused", "[codec]") {
  const Bytes content(1000, 42);
  const auto frame = compressed(content);
  for (std::size_t size = 0; size < frame.size(); ++size) {
    REQUIRE_FALSE(zstd_decompress(ByteView(frame).first(size), content.size()).has_value());
  }
  auto longer = frame;
  longer.push_back(0);
  REQUIRE_FALSE(zstd_decompress(longer, content.size()).has_value());
  auto twice = frame;
  twice.insert(twice.end(), frame.begin(), frame.end());
  REQUIRE_FALSE(zstd_decompress(twice, content.size()).has_value());
  REQUIRE_FALSE(zstd_decompress(frame, content.size() + 1).has_value());
  REQUIRE_FALSE(zstd_decompress(frame, content.size() - 1).has_value());
  REQUIRE_FALSE(zstd_decompress({}, 0).has_value());
}

TEST_CASE("a frame that does not state its content's size is refused", "[codec]") {
  const Bytes content(1000, 42);
  Bytes frame(ZSTD_compressBound(content.size()));
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
  const auto size =
      ZSTD_compress2(context, frame.data(), frame.size(), content.data(), content.size());
  ZSTD_freeCCtx(context);
  frame.resize(size);
  REQUIRE(zstd_decompress(frame, content.size()).error().code == ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace voxatlas
