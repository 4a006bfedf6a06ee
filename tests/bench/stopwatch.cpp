#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <numeric>

#include "bench/import_case.hpp"

namespace voxatlas::bench {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double Stopwatch::total_cpu() const { return std::accumulate(cpu_.begin(), cpu_.end(), 0.0); }

ImportTiming Stopwatch::finish() const {
  const double share = cpu_.empty() ? 0 : (cpu_seconds() - started_) / static_cast<double>(scans());
  const std::size_t cold = (scans() + 3) / 4;
  ImportTiming timing;
  timing.scans = static_cast<double>(scans());
  for (std::size_t i = 0; i < scans(); ++i) {
    (i < cold ? timing.cold_rays : timing.warm_rays) += rays_[i];
    (i < cold ? timing.cold_cpu : timing.warm_cpu) += cpu_[i] + share;
  }
  return timing;
}

}  // namespace voxatlas::bench
