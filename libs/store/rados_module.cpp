#include "store/rados_module.hpp"

extern "C" void voxatlas_open_rados_1(
    const voxatlas::RadosOptions& options,
    voxatlas::Result<std::unique_ptr<voxatlas::TileStore>>& opened) {
  auto store = voxatlas::RadosStore::open(options);
  if (store) {
    opened = std::unique_ptr<voxatlas::TileStore>(std::move(*store));
  } else {
    opened = voxatlas::pass_on(store);
  }
}
