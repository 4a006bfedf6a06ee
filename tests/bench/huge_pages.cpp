#include "bench/huge_pages.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace voxatlas::bench {

void put_heap_on_huge_pages(char** argv) {
  constexpr std::string_view wanted = "glibc.malloc.hugetlb=1";  // madvise(), no reserved pages.
  const char* tunables = std::getenv("GLIBC_TUNABLES");
  if (tunables != nullptr && std::string_view(tunables).find(wanted) != std::string_view::npos) {
    return;
  }
  // The C library reads them before main(), so only a program that starts anew has them.
  if (setenv("GLIBC_TUNABLES", wanted.data(), 1) != 0) return;
  execv("/proc/self/exe", argv);
}

}  // namespace voxatlas::bench
