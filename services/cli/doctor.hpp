#pragma once

#include <string>

#include "base/result.hpp"

namespace voxatlas {

struct DoctorOptions {
  std::string url;
  std::string data_dir = "voxatlas-data";  ///< As scripts/up has it.
  double listen = 2.5;                     ///< Seconds, for the services' statuses.
  bool json = false;                       ///< One JSON object a finding.
};

/// Looks at all that a set of services needs and prints what it finds, each with the sentence that
/// mends it (health.hpp). Changes nothing. Errors: kInvalid where something is wrong.
Status run_doctor(const DoctorOptions& options);

}  // namespace voxatlas
