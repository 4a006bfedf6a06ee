#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace voxatlas {

/// A log that lcm-logger wrote, event by event, whatever has become of the file since.
///
/// Source:  LCM's log format. An event is a sync word (0xEDA1DA01), its number and the time it was
///          heard (int64), the lengths of channel and data (int32), channel, data; big endian.
/// Damage:  an event is whole where its lengths fit the file and another event or the file's end
///          follows, or at least no other event begins within it. What lies between whole events
///          is passed over and counted: damage(). Of a log that was cut off, all but the last event
///          come. LCM's own reader stops at the first damage, drops the whole event before it, and
///          allocates what a hostile length says: it only gets to see what was found whole.
/// Errors:  open: kNotFound, kIo, kInvalid for what is no file. read: kIo.
/// Memory:  one event. Threads: one at a time.
class LcmLog {
 public:
  static Result<LcmLog> open(const std::string& path);
  ~LcmLog();
  LcmLog(LcmLog&&) noexcept;
  LcmLog& operator=(LcmLog&&) noexcept;

  struct Event {
    std::int64_t offset = 0;  ///< Of its sync word in the file.
    std::int64_t utime = 0;   ///< When it was heard.
    std::string channel;
    std::uint32_t size = 0;   ///< Bytes of data.
    bool is_followed = true;  ///< By an event or the file's end.
  };
  /// The next whole event; nullopt at the end.
  Result<std::optional<Event>> next();
  /// The data of an event, in any order.
  Result<Bytes> read(const Event& event);

  /// Where next() stands, and the whole file; bytes.
  std::int64_t position() const;
  std::int64_t file_bytes() const;
  /// What next() has passed over so far: kCorrupt, saying where and how much.
  std::optional<Error> damage() const;

 private:
  struct State;
  explicit LcmLog(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Whether a file is such a log: it begins with an event's sync word, or its name ends in ".lcm".
bool is_lcm_log(const std::string& path);

}  // namespace voxatlas
