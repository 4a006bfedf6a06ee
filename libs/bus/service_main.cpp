#include "bus/service_main.hpp"

#include <malloc.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>

#include "base/log.hpp"
#include "bus/service_loop.hpp"

namespace voxatlas {

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 64 << 20);
}

int run_service(const std::string& log_name, Precedence precedence,
                const std::function<Status()>& serve) {
  set_log_name(log_name);
  errno = 0;  // -1 may be a niceness.
  if (::nice(static_cast<int>(precedence)) == -1 && errno != 0) {
    log_warning("could not lower the own priority: {}", std::strerror(errno));
  }
  keep_freed_memory();
  stop_on_signals();
  try {
    const auto served = serve();
    if (served) {
      log_info("stopped");
      return 0;
    }
    log_error("{}", served.error().message);
  } catch (const std::exception& e) {
    log_error("{}", e.what());
  }
  return 1;
}

}  // namespace voxatlas
