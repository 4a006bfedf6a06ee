#include "tilestore/handout.hpp"

#include <algorithm>

namespace voxatlas {

bool Handout::is_heard(std::size_t i, const Seen& seen, std::int64_t now,
                       std::int64_t within) const {
  return now - std::max(seen.last_heard, compressors_[i].given) <= within;
}

std::optional<std::size_t> Handout::whom(std::span<const Seen> seen, std::int64_t now) const {
  std::optional<std::size_t> best;
  if (is_full()) return best;
  for (std::size_t i = 0; i < compressors_.size(); ++i) {
    const bool answers = seen[i].last_heard != 0 && is_heard(i, seen[i], now, kQuiet);
    if ((seen[i].holds && !answers) || !seen[i].has_room) continue;
    if (compressors_[i].out >= kMaxOutEach) continue;
    if (!best || compressors_[i].out < compressors_[*best].out) best = i;
  }
  return best;
}

void Handout::given(TileKey tile, std::size_t to, std::int64_t now) {
  out_.emplace(tile, to);
  compressors_[to].given = now;
  ++compressors_[to].out;
}

void Handout::answered(TileKey tile) {
  const auto found = out_.find(tile);
  if (found == out_.end()) return;
  --compressors_[found->second].out;
  out_.erase(found);
}

std::size_t Handout::take_back(std::span<const Seen> seen, std::int64_t now) {
  return std::erase_if(out_, [&](const auto& entry) {
    const std::size_t i = entry.second;
    if (is_heard(i, seen[i], now, kPatience)) return false;
    --compressors_[i].out;
    return true;
  });
}

}  // namespace voxatlas
