#include "compress/open_tiles.hpp"

namespace voxatlas {

std::vector<OpenTiles::Raw> OpenTiles::take_done(
    const std::function<std::int64_t(std::size_t)>& committed) {
  std::vector<Raw> done;
  for (auto& [session, tiles] : open_) {
    const auto is_done = [&](const Open& open) {
      return !open.result || open.result->number < committed(open.result->shard);
    };
    if (tiles.empty() || !is_done(tiles.front())) continue;
    Raw last{session, 0};
    while (!tiles.empty() && is_done(tiles.front())) {
      last.number = tiles.front().number;
      tiles.pop_front();
    }
    done.push_back(last);
  }
  std::erase_if(open_, [](const auto& entry) { return entry.second.empty(); });
  return done;
}

std::size_t OpenTiles::size() const {
  std::size_t size = 0;
  for (const auto& [session, tiles] : open_) size += tiles.size();
  return size;
}

}  // namespace voxatlas
