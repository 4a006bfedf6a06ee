#include "cli/log_input.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "bus/bot_core.hpp"
#include "bus/convert_scan.hpp"
#include "bus/lcm_log.hpp"
#include "bus/service_loop.hpp"
#include "cli/place_text.hpp"
#include "cli/progress.hpp"
#include "geodesy/enu_frame.hpp"
#include "geodesy/pose_track.hpp"

namespace voxatlas {
namespace {

/// A scan of the log: its parts, of a scan_t, or the one event of a cloud.
struct LoggedScan {
  std::vector<LcmLog::Event> events;
  bool is_cloud = false;
  std::int64_t utime = 0;
};

/// What was not taken, in one sentence: the first in full, and how many there were.
class Complaints {
 public:
  void add(Error error) {
    if (count_++ == 0) first_ = std::move(error);
  }
  std::optional<Error> all() const {
    if (count_ == 0) return std::nullopt;
    if (count_ == 1) return first_;
    return Error{first_.code, fmt::format("{} (and {} more such)", first_.message, count_ - 1)};
  }

 private:
  Error first_{};
  std::size_t count_ = 0;
};

/// Reads a log once and notes where its scans and poses are.
class LogIndex {
 public:
  explicit LogIndex(const LogInput& input) : input_(input) {}

  Status read(LcmLog& log);
  /// After read(): drops clouds that have no pose, and says what is left.
  Status settle(const LcmLog& log);

  std::vector<LoggedScan> scans;
  PoseTrack track{{}};
  std::optional<Error> ending;
  std::int64_t first_utime = 0;  ///< When the first event was heard.

 private:
  using ScanKey = std::tuple<std::string, std::int64_t, std::int64_t>;  // Source, session, seq.
  struct Parts {
    std::map<std::int16_t, LcmLog::Event> events;
    std::int16_t count = 0;
  };

  void take(const LcmLog::Event& event, ByteView data);
  void take_scan(const LcmLog::Event& event, ByteView data);
  void take_cloud(const LcmLog::Event& event, ByteView data);
  void take_pose(const LcmLog::Event& event, ByteView data);
  void complain(const LcmLog::Event& event, const Error& error);
  Status check_channels(std::size_t clouds) const;

  LogInput input_;
  std::map<ScanKey, Parts> open_;
  std::set<ScanKey> whole_;
  std::vector<std::pair<std::int64_t, Pose>> poses_;
  std::set<std::string> channels_, pose_channels_, cloud_channels_;
  std::size_t events_ = 0;
  Complaints complaints_;
};

Status LogIndex::read(LcmLog& log) {
  constexpr std::size_t kChannelsTold = 20;
  Progress progress;
  while (true) {
    auto event = log.next();
    if (!event) return pass_on(event);
    if (!*event) return {};
    auto data = log.read(**event);
    if (!data) return pass_on(data);
    if (events_++ == 0) first_utime = (*event)->utime;
    if (channels_.size() < kChannelsTold) channels_.insert((*event)->channel);
    take(**event, *data);
    if (stop_requested()) return fail(ErrorCode::kUnavailable, "stopped while reading the log");
    if (progress.due()) {
      progress.say(fmt::format("reading the log: {} %, {} scans",
                               100 * log.position() / log.file_bytes(), scans.size()));
    }
  }
}

void LogIndex::take(const LcmLog::Event& event, ByteView data) {
  switch (logged_type(data)) {
    case LoggedType::kScan:
      return take_scan(event, data);
    case LoggedType::kPointCloud:
      return take_cloud(event, data);
    case LoggedType::kPose:
      return take_pose(event, data);
    case LoggedType::kOther:
      return;
  }
}

void LogIndex::complain(const LcmLog::Event& event, const Error& error) {
  complaints_.add({error.code, fmt::format("{}, event at byte {}: {}", event.channel, event.offset,
                                           error.message)});
}

void LogIndex::take_scan(const LcmLog::Event& event, ByteView data) {
  const auto part = decode_message<scan_t>(data);
  const auto sound = part ? to_sensor_scan(*part) : Result<SensorScan>(SensorScan{});
  if (!part || !sound) {
    return complain(event, part ? sound.error() : part.error());
  }
  const ScanKey key{part->source, part->session, part->seq};
  if (whole_.contains(key)) return;  // Heard twice.
  auto& parts = open_[key];
  if (parts.events.empty()) parts.count = part->parts;
  if (parts.count != part->parts) {
    return complaints_.add(
        {ErrorCode::kCorrupt, fmt::format("scan {} of {}: {} parts, then {}", part->seq,
                                          part->source, parts.count, part->parts)});
  }
  parts.events.emplace(part->part, event);
  if (parts.events.size() < static_cast<std::size_t>(parts.count)) return;
  LoggedScan scan;
  for (auto& [number, one] : parts.events) scan.events.push_back(std::move(one));
  scan.utime = part->utime;
  scans.push_back(std::move(scan));
  open_.erase(key);
  whole_.insert(key);
}

void LogIndex::take_cloud(const LcmLog::Event& event, ByteView data) {
  if (!input_.cloud_channel.empty() && event.channel != input_.cloud_channel) return;
  const auto cloud = decode_point_cloud(data);
  if (!cloud) return complain(event, cloud.error());
  cloud_channels_.insert(event.channel);
  scans.push_back({{event}, true, cloud->utime});
}

void LogIndex::take_pose(const LcmLog::Event& event, ByteView data) {
  if (!input_.pose_channel.empty() && event.channel != input_.pose_channel) return;
  const auto pose = decode_bot_pose(data);
  if (!pose) return complain(event, pose.error());
  pose_channels_.insert(event.channel);
  poses_.emplace_back(pose->utime, pose->local_from_body);
}

/// Whether it is clear which poses belong to the clouds.
Status LogIndex::check_channels(std::size_t clouds) const {
  if (clouds == 0) return {};
  if (pose_channels_.empty()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} holds clouds, but no bot_core.pose_t{} says where they were "
                            "taken",
                            input_.path, fmt::join(cloud_channels_, " and "),
                            input_.pose_channel.empty() ? "" : " on " + input_.pose_channel));
  }
  if (pose_channels_.size() > 1) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: poses came on {}; say which with --pose-channel", input_.path,
                            fmt::join(pose_channels_, " and ")));
  }
  return {};
}

Status LogIndex::settle(const LcmLog& log) {
  const auto clouds = std::ranges::count_if(scans, &LoggedScan::is_cloud);
  if (auto clear = check_channels(static_cast<std::size_t>(clouds)); !clear) return clear;
  track = PoseTrack(std::exchange(poses_, {}));
  std::erase_if(scans, [this](const LoggedScan& scan) {
    if (!scan.is_cloud) return false;
    auto placed = track.at(scan.utime);
    if (!placed)
      complaints_.add({placed.error().code, "cloud left out: " + placed.error().message});
    return !placed;
  });
  if (auto damage = log.damage()) complaints_.add(std::move(*damage));
  for (const auto& [key, parts] : open_) {
    complaints_.add(
        {ErrorCode::kCorrupt,
         fmt::format("scan {} of {} has {} of its {} parts in the log, and is left out",
                     std::get<2>(key), std::get<0>(key), parts.events.size(), parts.count)});
  }
  open_.clear();
  whole_.clear();
  ending = complaints_.all();
  if (!scans.empty()) return {};
  if (ending) return tl::unexpected<Error>(*ending);
  return fail(
      ErrorCode::kNotFound,
      fmt::format("{}: no voxatlas.scan_t and no bot_core.pointcloud_t among its {} events "
                  "({})",
                  input_.path, events_,
                  channels_.empty() ? "none" : fmt::format("{}", fmt::join(channels_, ", "))));
}

/// An open log with its index: what ScanInput::read reads from.
struct LogScans {
  Result<InputScan> read(std::size_t index);
  Result<InputScan> read_cloud(const LoggedScan& scan);

  LcmLog log;
  LogIndex index;
  Pose ecef_from_local;
};

Result<InputScan> LogScans::read(std::size_t number) {
  const LoggedScan& wanted = index.scans.at(number);
  if (wanted.is_cloud) return read_cloud(wanted);
  InputScan whole;
  for (const auto& event : wanted.events) {
    auto data = log.read(event);
    if (!data) return pass_on(data);
    auto part = decode_message<scan_t>(*data);
    if (!part) return pass_on(part);
    auto seen = to_sensor_scan(*part);
    if (!seen) return pass_on(seen);
    if (!whole.sigma) {
      whole = {std::move(*seen), std::nullopt, part->sigma, part->min_range};
      continue;
    }
    auto& points = whole.scan.points_sensor;
    points.insert(points.end(), seen->points_sensor.begin(), seen->points_sensor.end());
    auto& colours = whole.scan.colours;
    colours.insert(colours.end(), seen->colours.begin(), seen->colours.end());
  }
  if (!whole.scan.colours.empty() && whole.scan.colours.size() != whole.scan.points_sensor.size()) {
    whole.scan.colours.clear();
    whole.damage = Error{ErrorCode::kCorrupt, "only some of its parts have colours: none is taken"};
  }
  return whole;
}

Result<InputScan> LogScans::read_cloud(const LoggedScan& wanted) {
  auto data = log.read(wanted.events.front());
  if (!data) return pass_on(data);
  auto cloud = decode_point_cloud(*data);
  if (!cloud) return pass_on(cloud);
  auto local_from_body = index.track.at(cloud->utime);
  if (!local_from_body) return pass_on(local_from_body);
  auto placed = ecef_from_local * *local_from_body;
  if (!placed) return pass_on(placed);
  InputScan result;
  result.scan.points_sensor = std::move(cloud->points);
  result.scan.colours = std::move(cloud->colours);
  result.scan.ecef_from_sensor = *placed;
  result.scan.utime = cloud->utime;
  result.damage = std::move(cloud->colour_problem);
  return result;
}

}  // namespace

Result<ScanInput> open_log(const LogInput& input) {
  auto log = LcmLog::open(input.path);
  if (!log) return pass_on(log);
  // Owned by the closure below.
  auto scans = std::make_shared<LogScans>(LogScans{std::move(*log), LogIndex(input), Pose()});
  if (!input.origin.empty()) {
    auto origin = parse_place("--origin", input.origin);
    if (!origin) return pass_on(origin);
    auto frame = EnuFrame::at(*origin);
    if (!frame) return pass_on(frame, "--origin " + input.origin);
    scans->ecef_from_local = frame->ecef_from_enu();
  }
  if (auto read = scans->index.read(scans->log); !read) return pass_on(read);
  if (auto settled = scans->index.settle(scans->log); !settled) return pass_on(settled);

  ScanInput result;
  const auto file = std::filesystem::path(input.path).filename();
  result.name = file.stem();
  // Not of the folder: a log that was moved is the same; one recorded anew is another.
  result.identity =
      identity_of_input(fmt::format("{}\n{}\n{}\n{}\n{}", file.string(), scans->index.first_utime,
                                    input.origin, input.cloud_channel, input.pose_channel));
  result.scans = scans->index.scans.size();
  result.ending = scans->index.ending;
  result.read = [scans](std::size_t index) { return scans->read(index); };
  return result;
}

}  // namespace voxatlas
