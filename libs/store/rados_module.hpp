#pragma once

#include <memory>

#include "store/rados_store.hpp"

namespace voxatlas {

/// The one door of voxatlas-rados.so, which programs load when a model lies in a cluster: so they
/// start where librados is not installed, and Debian's package only recommends it. All else that
/// the module needs of ours it takes from the program that loads it. A name carries the version:
/// a module of another build must not be taken.
using OpenRados = void(const RadosOptions& options, Result<std::unique_ptr<TileStore>>& opened);
inline constexpr const char* kOpenRadosName = "voxatlas_open_rados_1";

}  // namespace voxatlas
