#include "store/store_location.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "store/rados_module.hpp"

namespace voxatlas {

static constexpr std::string_view kCluster = "rados:";
static constexpr const char* kModule = "voxatlas-rados.so";

static std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from != std::string_view::npos;) {
    const auto comma = text.find(',', from);
    parts.emplace_back(text.substr(from, comma - from));
    from = comma == std::string_view::npos ? comma : comma + 1;
  }
  return parts;
}

Result<StoreLocation> StoreLocation::parse(const std::string& text) {
  StoreLocation location;
  if (!text.starts_with(kCluster)) {
    if (text.empty()) return fail(ErrorCode::kInvalid, "the name of a model's folder is empty");
    location.folder = text;
    return location;
  }
  const auto parts = split(std::string_view(text).substr(kCluster.size()));
  for (const auto& part : parts) {
    if (part.empty() || parts.size() < 2 || parts.size() > 4) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("\"{}\" is no place of a model: rados:CONF,POOL[,MODEL[,CLIENT]], "
                              "such as rados:/etc/ceph/ceph.conf,tiles",
                              text));
    }
  }
  location.cluster.conf = parts[0];
  location.cluster.pool = parts[1];
  if (parts.size() > 2) location.cluster.model = parts[2];
  if (parts.size() > 3) location.cluster.client = parts[3];
  return location;
}

std::string StoreLocation::text() const {
  if (embedded()) return folder;
  return fmt::format("{}{},{},{},{}", kCluster, cluster.conf, cluster.pool, cluster.model,
                     cluster.client);
}

/// Beside the program where it was built, in PREFIX/lib/voxatlas where it was installed.
static Result<OpenRados*> load_module() {
  std::error_code error;
  const auto here = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const auto& folder : {here, here.parent_path() / "lib" / "voxatlas"}) {
    const auto file = folder / kModule;
    if (!std::filesystem::exists(file, error)) continue;
    void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // Until the process ends.
    if (module == nullptr) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("{} cannot be loaded: {} (apt-get install librados2)", file.string(),
                              ::dlerror()));
    }
    if (auto* open = reinterpret_cast<OpenRados*>(::dlsym(module, kOpenRadosName))) return open;
    return fail(ErrorCode::kUnavailable, file.string() + " is of another version of voxatlas");
  }
  return fail(ErrorCode::kUnavailable,
              fmt::format("a model in a Ceph cluster takes {}, which is not beside {}: install the "
                          "package voxatlas-rados, or build after scripts/setup --rados",
                          kModule, here.string()));
}

Result<std::unique_ptr<TileStore>> open_store(const StoreLocation& location, ShardId shard,
                                              const RocksDbOptions& options) {
  if (location.embedded()) {
    auto store = RocksDbStore::open(shard_folder(location.folder, shard), options);
    if (!store) return pass_on(store);
    return std::unique_ptr<TileStore>(std::move(*store));
  }
  auto open = load_module();
  if (!open) return pass_on(open);
  Result<std::unique_ptr<TileStore>> opened;
  (*open)(location.cluster, opened);
  return opened;
}

std::string shard_folder(const std::string& directory, ShardId shard) {
  return fmt::format("{}/shard-{}", directory, shard);
}

}  // namespace voxatlas
