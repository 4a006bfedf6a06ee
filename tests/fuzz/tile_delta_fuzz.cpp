// Any bytes are refused or are the only encoding of a valid delta, which a tile then takes.
#include "base/check.hpp"
#include "octree/tile_delta.hpp"
#include "octree/tile_tree.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace voxatlas;
  const auto delta = decode_delta({data, size});
  if (!delta) {
    VOX_CHECK(delta.error().code == ErrorCode::kCorrupt);
    return 0;
  }
  VOX_CHECK(delta->valid());
  Bytes again;
  encode_delta(*delta, again);
  VOX_CHECK(again == Bytes(data, data + size));
  TileTree tree;
  tree.apply(*delta, SensorModel::standard());
  VOX_CHECK(tree.empty() == delta->empty());
  return 0;
}
