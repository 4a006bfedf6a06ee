#include "bus/lcm_log.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

namespace voxatlas {
namespace {

constexpr std::array<std::uint8_t, 4> kSync = {0xed, 0xa1, 0xda, 0x01};
constexpr std::int64_t kHeaderBytes = 4 + 8 + 8 + 4 + 4;
constexpr std::int32_t kLongestChannel = 999;  ///< LCM's own reader takes no longer ones.
constexpr std::int64_t kSearchBytes = std::int64_t{1} << 20;

template <class T>
T big_endian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[i];
  return static_cast<T>(value);
}

struct Header {
  std::int64_t utime = 0;
  std::int32_t channel_bytes = 0, data_bytes = 0;

  std::int64_t event_bytes() const { return kHeaderBytes + channel_bytes + data_bytes; }
};

}  // namespace

struct LcmLog::State {
  State(const std::string& p, std::int64_t bytes) : path(p), log(p, "r"), size(bytes) {}

  int fd() { return ::fileno(log.getFilePtr()); }
  /// As many bytes as there are, at most `count`. Does not move LCM's own place in the file.
  Result<Bytes> bytes_at(std::int64_t at, std::int64_t count);
  Result<bool> sync_at(std::int64_t at);
  /// A header whose lengths can be, and fit the file.
  Result<std::optional<Header>> header_at(std::int64_t at);
  /// The first such header in [from, end), or end.
  Result<std::int64_t> find_header(std::int64_t from, std::int64_t end);
  Result<std::optional<Event>> event_at(std::int64_t at, const Header& header);
  void pass_over(std::int64_t to);

  std::string path;
  lcm::LogFile log;
  std::int64_t size;
  std::int64_t at = 0;
  std::int64_t damaged_at = 0, damaged_bytes = 0;
};

LcmLog::LcmLog(std::unique_ptr<State> state) : state_(std::move(state)) {}
LcmLog::~LcmLog() = default;
LcmLog::LcmLog(LcmLog&&) noexcept = default;
LcmLog& LcmLog::operator=(LcmLog&&) noexcept = default;

Result<LcmLog> LcmLog::open(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) {
    return fail(errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                fmt::format("{}: {}", path, std::strerror(errno)));
  }
  if (!S_ISREG(info.st_mode)) return fail(ErrorCode::kInvalid, path + ": is no file");
  auto state = std::make_unique<State>(path, info.st_size);
  if (!state->log.good()) {
    return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  }
  return LcmLog(std::move(state));
}

Result<Bytes> LcmLog::State::bytes_at(std::int64_t from, std::int64_t count) {
  Bytes bytes(static_cast<std::size_t>(std::clamp<std::int64_t>(size - from, 0, count)));
  std::size_t have = 0;
  while (have < bytes.size()) {
    const auto got = ::pread(fd(), bytes.data() + have, bytes.size() - have,
                             from + static_cast<std::int64_t>(have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
    if (got == 0) break;  // Somebody has cut the file meanwhile.
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

Result<bool> LcmLog::State::sync_at(std::int64_t from) {
  auto bytes = bytes_at(from, kSync.size());
  if (!bytes) return pass_on(bytes);
  return std::ranges::equal(*bytes, kSync);
}

Result<std::optional<Header>> LcmLog::State::header_at(std::int64_t from) {
  auto bytes = bytes_at(from, kHeaderBytes);
  if (!bytes) return pass_on(bytes);
  if (bytes->size() < kHeaderBytes || !std::equal(kSync.begin(), kSync.end(), bytes->begin())) {
    return std::optional<Header>{};
  }
  const Header header{big_endian<std::int64_t>(bytes->data() + 12),
                      big_endian<std::int32_t>(bytes->data() + 20),
                      big_endian<std::int32_t>(bytes->data() + 24)};
  const bool can_be = header.channel_bytes > 0 && header.channel_bytes <= kLongestChannel &&
                      header.data_bytes >= 0 && header.event_bytes() <= size - from;
  return can_be ? std::optional(header) : std::nullopt;
}

Result<std::int64_t> LcmLog::State::find_header(std::int64_t from, std::int64_t end) {
  while (from < end) {
    auto bytes = bytes_at(from, std::min(kSearchBytes, end - from + 3));
    if (!bytes) return pass_on(bytes);
    if (bytes->size() < kSync.size()) return end;
    auto found = bytes->begin();
    while ((found = std::search(found, bytes->end(), kSync.begin(), kSync.end())) != bytes->end()) {
      const auto candidate = from + (found - bytes->begin());
      if (candidate >= end) return end;
      auto header = header_at(candidate);
      if (!header) return pass_on(header);
      if (*header) return candidate;
      ++found;
    }
    from += static_cast<std::int64_t>(bytes->size()) - 3;  // A sync word may lie across the border.
  }
  return end;
}

/// The event of this header if it is whole.
Result<std::optional<LcmLog::Event>> LcmLog::State::event_at(std::int64_t from,
                                                             const Header& header) {
  const auto end = from + header.event_bytes();
  auto followed = sync_at(end);
  if (!followed) return pass_on(followed);
  const bool at_end = end == size;
  if (!at_end && !*followed) {
    auto within = find_header(from + 1, end);
    if (!within) return pass_on(within);
    if (*within < end) return std::optional<Event>{};
  }
  auto channel = bytes_at(from + kHeaderBytes, header.channel_bytes);
  if (!channel) return pass_on(channel);
  Event event;
  event.offset = from;
  event.utime = header.utime;
  event.channel.assign(as_text(*channel));
  event.size = static_cast<std::uint32_t>(header.data_bytes);
  event.is_followed = at_end || *followed;
  return std::optional(std::move(event));
}

void LcmLog::State::pass_over(std::int64_t to) {
  if (damaged_bytes == 0) damaged_at = at;
  damaged_bytes += to - at;
  at = to;
}

Result<std::optional<LcmLog::Event>> LcmLog::next() {
  auto& state = *state_;
  while (state.at < state.size) {
    auto header = state.header_at(state.at);
    if (!header) return pass_on(header);
    if (*header) {
      auto event = state.event_at(state.at, **header);
      if (!event) return pass_on(event);
      if (*event) {
        state.at += (*header)->event_bytes();
        return std::move(*event);
      }
    }
    auto next = state.find_header(state.at + 1, state.size);
    if (!next) return pass_on(next);
    state.pass_over(*next);
  }
  return std::optional<Event>{};
}

Result<Bytes> LcmLog::read(const Event& event) {
  auto& state = *state_;
  if (event.is_followed && ::fseeko(state.log.getFilePtr(), event.offset, SEEK_SET) == 0) {
    if (const lcm::LogEvent* read = state.log.readNextEvent();
        read != nullptr && read->datalen == static_cast<std::int32_t>(event.size)) {
      const auto* data = static_cast<const std::uint8_t*>(read->data);
      return Bytes(data, data + read->datalen);
    }
  }
  const auto channel_bytes = static_cast<std::int64_t>(event.channel.size());
  auto data = state.bytes_at(event.offset + kHeaderBytes + channel_bytes, event.size);
  if (!data) return pass_on(data);
  if (data->size() == event.size) return data;
  return fail(ErrorCode::kIo, fmt::format("{}: the event at {} is gone", state.path, event.offset));
}

std::int64_t LcmLog::position() const { return state_->at; }
std::int64_t LcmLog::file_bytes() const { return state_->size; }

std::optional<Error> LcmLog::damage() const {
  if (state_->damaged_bytes == 0) return std::nullopt;
  return Error{ErrorCode::kCorrupt,
               fmt::format("{}: {} bytes from byte {} on are no whole event; the log was cut off "
                           "or damaged",
                           state_->path, state_->damaged_bytes, state_->damaged_at)};
}

bool is_lcm_log(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return false;
  std::array<std::uint8_t, 4> first{};
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(first.data()), first.size());
  return (in && first == kSync) || std::filesystem::path(path).extension() == ".lcm";
}

}  // namespace voxatlas
