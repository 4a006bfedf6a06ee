#include "bus/socket_drops.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace voxatlas {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(" \t", at)) != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::uint64_t number(std::string_view text) {
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// The inodes of all sockets this process has open.
std::set<std::uint64_t> own_sockets() {
  constexpr std::string_view kSocket = "socket:[";
  std::set<std::uint64_t> inodes;
  std::error_code none;
  for (std::filesystem::directory_iterator it("/proc/self/fd", none), end; it != end && !none;
       it.increment(none)) {
    std::error_code gone;
    const std::string target = std::filesystem::read_symlink(it->path(), gone);
    if (target.starts_with(kSocket)) {
      inodes.insert(number(std::string_view(target).substr(kSocket.size())));
    }
  }
  return inodes;
}

}  // namespace

std::uint64_t drops_in(std::string_view text, const std::set<std::uint64_t>& inodes) {
  constexpr std::size_t kInode = 9, kDrops = 12;
  std::uint64_t sum = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.size() > kDrops && inodes.contains(number(words[kInode]))) {
      sum += number(words[kDrops]);
    }
  }
  return sum;
}

std::uint64_t socket_drops() {
  std::ifstream in("/proc/net/udp");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  return drops_in(text, own_sockets());
}

}  // namespace voxatlas
