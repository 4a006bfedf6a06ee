#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace voxatlas {

/// Who may publish a source: whoever claimed it first and goes on claiming.
///
/// Source:  lcmtypes/README.md. Time: microseconds of one steady clock, given with each call.
/// Threads: one at a time. Memory: kMaxClaims.
class SourceClaims {
 public:
  static constexpr std::int64_t kLeaseUs = 2'000'000;  ///< A claim not made again lapses.
  static constexpr std::size_t kMaxClaims = 4096;

  /// Claims for `client` and returns whose the source is now; 0 where nothing lapses and
  /// no more claims are kept.
  std::int64_t claim(const std::string& source, std::int64_t client, std::int64_t now);
  void give_back(const std::string& source, std::int64_t client);
  /// Whose it is; 0: nobody's.
  std::int64_t holder(const std::string& source, std::int64_t now) const;

 private:
  struct Claim {
    std::int64_t holder = 0;
    std::int64_t until = 0;
  };
  std::map<std::string, Claim> claims_;
};

}  // namespace voxatlas
