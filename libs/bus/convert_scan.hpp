#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bus/wire.hpp"
#include "integrate/sensor_scan.hpp"

namespace voxatlas {

/// Whose scan it is, and which: what makes a scan count once.
struct ScanIdentity {
  std::string source;        ///< 1 to 64 bytes.
  std::int64_t session = 0;  ///< Not negative.
  std::int64_t seq = 0;      ///< 0, 1, 2, ... without gaps.

  static constexpr std::size_t kMaxSourceBytes = 64;
  friend auto operator<=>(const ScanIdentity&, const ScanIdentity&) = default;
};

/// Errors: kOutOfRange for an empty or overlong source, a negative session or seq.
Result<ScanIdentity> identity_of(const scan_t& message);

/// The points of a scan or of one part of it, as the sensor saw them. Errors: as to_scan.
Result<SensorScan> to_sensor_scan(const scan_t& message);

/// A whole scan (part 0 of 1) in ECEF, each endpoint rotated and moved in double.
/// Errors: kOutOfRange for a pose that is none (Pose's errors), kCorrupt for sizes that contradict.
///         sigma is the integrator's to judge.
Result<Scan> to_scan(const scan_t& message);

/// The whole scan as one message, for reliable streams.
scan_t to_message(const SensorScan& scan, const ScanIdentity& identity, double sigma,
                  double min_range);

/// The same in parts of at most 60 000 bytes encoded, for VOXATLAS_SCAN.
/// Errors: kOutOfRange where it would take more than 64 parts.
Result<std::vector<scan_t>> to_parts(const scan_t& whole);

}  // namespace voxatlas
