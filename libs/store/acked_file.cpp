#include "store/acked_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/crc32c.hpp"

namespace voxatlas {

/// The whole file: number and CRC-32C of its eight bytes.
static constexpr std::size_t kFileBytes = 12;

AckedFile::~AckedFile() {
  if (file_ >= 0) ::close(file_);
}

static tl::unexpected<Error> refused(const std::string& path, const char* what) {
  return fail(ErrorCode::kIo, fmt::format("cannot {} {}: {}", what, path, std::strerror(errno)));
}

Status AckedFile::open(const std::string& path) {
  path_ = path;
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) return refused(path, "open");
  Bytes bytes(kFileBytes);
  const auto got = ::pread(file_, bytes.data(), bytes.size(), 0);
  if (got < 0) return refused(path, "read");
  // A power cut can leave the file empty or its page not yet written: then nothing is known.
  bytes.resize(static_cast<std::size_t>(got));
  if (bytes.empty() || bytes == Bytes(kFileBytes)) return {};
  ByteReader reader(bytes);
  const auto sequence = reader.get<std::uint64_t>();
  const auto sum = reader.get<std::uint32_t>();
  if (!reader.ok() || sum != crc32c(ByteView(bytes).first(sizeof sequence))) {
    return fail(ErrorCode::kCorrupt, fmt::format("{}: its checksum is wrong", path));
  }
  sequence_ = sequence;
  return {};
}

Status AckedFile::raise(std::uint64_t sequence) {
  const std::lock_guard lock(mutex_);
  if (sequence <= sequence_) return {};
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.put(sequence);
  writer.put(crc32c(bytes));
  if (::pwrite(file_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return refused(path_, "write");
  }
  sequence_ = sequence;
  return {};
}

Status AckedFile::sync() {
  const std::lock_guard lock(mutex_);
  if (file_ >= 0 && ::fdatasync(file_) != 0) return refused(path_, "sync");
  return {};
}

}  // namespace voxatlas
