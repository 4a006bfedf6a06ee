#include "codec/zstd_frame.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <memory>
#include <new>

#include "base/check.hpp"

namespace voxatlas {
namespace {

/// A thread's own, kept: Zstandard's one-shot calls take megabytes or a hundred kilobytes from the
/// system each time and give them back, which for a small tile is a tenth of its decoding.
template <class Context, Context* (*create)(), std::size_t (*destroy)(Context*)>
Context* context_of_thread() {
  struct Destroy {
    void operator()(Context* context) const { destroy(context); }
  };
  thread_local const std::unique_ptr<Context, Destroy> context(create());
  if (context == nullptr) throw std::bad_alloc();
  return context.get();
}

constexpr auto compressor = context_of_thread<ZSTD_CCtx, ZSTD_createCCtx, ZSTD_freeCCtx>;
constexpr auto decompressor = context_of_thread<ZSTD_DCtx, ZSTD_createDCtx, ZSTD_freeDCtx>;

}  // namespace

void zstd_compress(ByteView content, int level, Bytes& out) {
  const std::size_t at = out.size();
  out.resize(at + ZSTD_compressBound(content.size()));
  const std::size_t size = ZSTD_compressCCtx(compressor(), out.data() + at, out.size() - at,
                                             content.data(), content.size(), level);
  VOX_CHECK(ZSTD_isError(size) == 0);  // With room for the bound, only a lack of memory fails.
  out.resize(at + size);
}

Result<Bytes> zstd_decompress(ByteView frame, std::size_t size) {
  const auto stated = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (stated == ZSTD_CONTENTSIZE_ERROR || stated == ZSTD_CONTENTSIZE_UNKNOWN || stated != size) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("Zstandard frame of {} bytes does not state a content of {}",
                            frame.size(), size));
  }
  const std::size_t length = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(length) != 0 || length != frame.size()) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("{} bytes are not one whole Zstandard frame", frame.size()));
  }
  Bytes content(size);
  const std::size_t got = ZSTD_decompressDCtx(decompressor(), content.data(), content.size(),
                                              frame.data(), frame.size());
  if (ZSTD_isError(got) != 0 || got != size) {
    return fail(ErrorCode::kCorrupt,
                fmt::format("Zstandard frame of {} bytes: {}", frame.size(),
                            ZSTD_isError(got) != 0 ? ZSTD_getErrorName(got) : "too short"));
  }
  return content;
}

}  // namespace voxatlas
