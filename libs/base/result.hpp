#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace voxatlas {

enum class ErrorCode {
  kOutOfRange,   ///< A value outside its documented domain, such as a point off the index cube.
  kInvalid,      ///< Input that cannot be meant: a misspelt option, a parameter that contradicts.
  kCorrupt,      ///< Bytes from the bus, a file or disk that break their format or checksum.
  kNotFound,     ///< A tile, file or service that is not there.
  kIo,           ///< The operating system or a library refused; the message carries its reason.
  kNoSpace,      ///< The disk is full; nothing was written, the same call may succeed later.
  kFenced,       ///< Another owner has taken the shard; this one must stop writing.
  kUnknown,      ///< It may or may not have happened: read back, then retry.
  kUnavailable,  ///< Nobody answered in time.
};

/// The enumerator's name without its k, for messages and status: "corrupt", "no_space".
const char* name_of(ErrorCode code);

/// What went wrong, for a program (`code`) and for a person (`message`: what, where, which value).
struct Error {
  ErrorCode code;
  std::string message;
};

/// A `T` or an `Error`. The compiler warns when a caller drops one.
/// Same interface as C++23's std::expected, which replaces the base class one day.
template <class T>
class [[nodiscard]] Result : public tl::expected<T, Error> {
  using tl::expected<T, Error>::expected;
};

using Status = Result<void>;

/// Ends a function that returns any Result: `return fail(ErrorCode::kIo, "...")`.
inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

/// Hands a callee's error on to the caller: `if (!tile) return pass_on(tile)`.
template <class T>
tl::unexpected<Error> pass_on(Result<T>& failed) {
  return tl::unexpected<Error>(std::move(failed.error()));
}

/// The same, with what the caller was about in front of the callee's message.
template <class T>
tl::unexpected<Error> pass_on(Result<T>& failed, const std::string& context) {
  return tl::unexpected<Error>(Error{failed.error().code, context + ": " + failed.error().message});
}

}  // namespace voxatlas
