#include "render/renderer_roll.hpp"

#include "grid/region_key.hpp"

namespace voxatlas {
namespace {

std::uint64_t weight(std::int64_t renderer, std::int64_t client) {
  return splitmix64(splitmix64(static_cast<std::uint64_t>(renderer)) ^
                    static_cast<std::uint64_t>(client));
}

}  // namespace

void RendererRoll::on_status(const status_t& status, std::int64_t now) {
  if (status.service != "render" || status.instance == self_) return;
  std::erase_if(heard_, [now](const auto& other) { return now - other.second > kAlive; });
  if (status.ready == 1) {
    heard_[status.instance] = now;
  } else {
    heard_.erase(status.instance);
  }
}

bool RendererRoll::answers(std::int64_t client, std::int64_t now) const {
  const std::uint64_t mine = weight(self_, client);
  for (const auto& [instance, heard] : heard_) {
    if (now - heard <= kAlive && weight(instance, client) > mine) return false;
  }
  return true;
}

std::size_t RendererRoll::alive(std::int64_t now) const {
  std::size_t count = 1;
  for (const auto& [instance, heard] : heard_) count += now - heard <= kAlive;
  return count;
}

}  // namespace voxatlas
