#include "tilestore/tile_encodings.hpp"

#include <algorithm>

namespace voxatlas {

std::list<TileEncodings::Kept>::iterator TileEncodings::find(TileKey key, int depth) {
  return std::ranges::find_if(
      kept_, [&](const Kept& kept) { return kept.encoded.key == key && kept.depth == depth; });
}

Result<EncodedTile> TileEncodings::of(TileKey key, int depth, bool goes_on) {
  const auto kept = find(key, depth);
  if (kept == kept_.end()) return atlas_.encoded(key, depth);
  auto encoded = std::move(kept->encoded);
  bytes_ -= encoded.bytes.size();
  kept_.erase(kept);
  return goes_on ? std::move(encoded) : atlas_.encoded(key, depth);
}

void TileEncodings::keep(EncodedTile encoded, int depth) {
  bytes_ += encoded.bytes.size();
  kept_.push_back({std::move(encoded), depth});
  for (; bytes_ > kMostBytes && kept_.size() > 1; kept_.pop_front()) {
    bytes_ -= kept_.front().encoded.bytes.size();
  }
}

}  // namespace voxatlas
