#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace voxatlas {

/// Says on standard error how long work goes: from its first second on, once a second, in place on
/// a terminal and as lines elsewhere.
class Progress {
 public:
  Progress();
  ~Progress();  ///< Ends a line that was written in place.

  /// Cheap to call often; `text` such as "37 of 40 scans durable, 1.2 M rays/s".
  void say(std::string_view text);
  /// True about once a second: whether say() would write, for texts that are work to make.
  bool due() const;

 private:
  bool terminal_;
  bool open_line_ = false;
  std::int64_t next_;
};

}  // namespace voxatlas
