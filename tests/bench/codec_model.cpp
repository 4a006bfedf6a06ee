#include <bit>
#include <map>

#include "bench/codec_case.hpp"
#include "bench/import_scans.hpp"
#include "integrate/integrator.hpp"
#include "sim/city.hpp"
#include "sim/drive.hpp"

namespace voxatlas::bench {
namespace {

constexpr double kSigma = 0.02;

class Builder {
 public:
  void add(const Scan& scan) {
    const auto delta = *integrator_.integrate(scan);
    for (const auto& [key, change] : delta.tiles) tiles_[key].apply(change, model_);
    ByteWriter points(scans_.emplace_back());
    for (const auto& endpoint : scan.endpoints_ecef) {
      const Eigen::Vector3f point = (endpoint - scan.origin_ecef).cast<float>();
      for (const float coordinate : point) points.put(std::bit_cast<std::uint32_t>(coordinate));
    }
  }

  CodecModel finish() {
    CodecModel model;
    model.scans = std::move(scans_);
    for (auto& [key, tile] : tiles_) {
      tile.prune();
      model.tiles.push_back(std::move(tile));
    }
    return model;
  }

 private:
  SensorModel model_ = SensorModel::standard();
  Integrator integrator_{Grid::standard(), IntegrationParameters{}};
  std::map<TileKey, TileTree> tiles_;
  std::vector<Bytes> scans_;
};

}  // namespace

Result<CodecModel> real_model(const std::string& folder, const std::string& poses,
                              std::size_t scans) {
  auto read = real_scans(folder, poses, scans);
  if (!read) return pass_on(read);
  Builder builder;
  for (const auto& scan : *read) builder.add(scan);
  return builder.finish();
}

Result<CodecModel> simulated_model(std::size_t scans, bool coloured) {
  auto city = City::create({});
  if (!city) return pass_on(city);
  DriveOptions options;
  options.scans = scans;
  auto drive = Drive::create(*city, options);
  if (!drive) return pass_on(drive);
  Builder builder;
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    auto seen = drive->simulate(i);
    if (!coloured) seen.colours.clear();
    builder.add(to_scan(seen, kSigma, 0));
  }
  return builder.finish();
}

}  // namespace voxatlas::bench
