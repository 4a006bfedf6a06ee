#include "cli/camera_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <utility>

#include "cli/place_text.hpp"

namespace voxatlas {
namespace {

struct TrackPoint {
  double seconds;
  Eigen::Vector3d eye_ecef, target_ecef;
};

Result<TrackPoint> parse_point(const std::string& line) {
  std::istringstream words(line);
  std::string seconds, eye, target, more;
  words >> seconds >> eye >> target;
  TrackPoint point{};
  const auto parsed =
      std::from_chars(seconds.data(), seconds.data() + seconds.size(), point.seconds);
  if (parsed.ec != std::errc{} || parsed.ptr != seconds.data() + seconds.size() || words >> more) {
    return fail(ErrorCode::kInvalid, "give SECONDS LAT,LON,HEIGHT LAT,LON,HEIGHT: " + line);
  }
  const std::array places = {std::pair{eye, &point.eye_ecef},
                             std::pair{target, &point.target_ecef}};
  for (const auto& [text, p_ecef] : places) {
    auto place = parse_place("place", text);
    if (!place) return pass_on(place);
    auto ecef = to_ecef(*place);
    if (!ecef) return pass_on(ecef);
    *p_ecef = *ecef;
  }
  return point;
}

Result<std::vector<TrackPoint>> read_points(const std::string& file) {
  std::ifstream in(file);
  if (!in) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read", file));
  std::vector<TrackPoint> points;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    auto point = parse_point(line);
    if (!point) return pass_on(point, fmt::format("{}:{}", file, number));
    const bool ascends =
        points.empty() ? std::isfinite(point->seconds) : point->seconds > points.back().seconds;
    if (!ascends) {
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}:{}: {} s do not ascend", file, number, point->seconds));
    }
    points.push_back(*point);
  }
  if (points.empty()) return fail(ErrorCode::kInvalid, fmt::format("{}: it has no line", file));
  return points;
}

}  // namespace

Result<Bytes> path_rows(const std::vector<Camera>& track, double rate) {
  if (track.size() > kLongestTrack) {
    return fail(ErrorCode::kInvalid, fmt::format("{} pictures are more than the {} one request "
                                                 "takes: ask for parts of the path",
                                                 track.size(), kLongestTrack));
  }
  Bytes rows;
  ByteWriter writer(rows);
  for (std::size_t i = 0; i < track.size(); ++i) {
    writer.put(static_cast<double>(i) / rate);
    for (const double x : track[i].position()) writer.put(x);
    const auto& q = track[i].orientation();
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) writer.put(x);
  }
  return rows;
}

Result<std::vector<Camera>> orbit(const Camera& first, const Eigen::Vector3d& target_ecef,
                                  int count) {
  const Eigen::Vector3d up = up_at(target_ecef);
  const Eigen::Vector3d out = first.position() - target_ecef;
  std::vector<Camera> track;
  for (int i = 0; i < count; ++i) {
    const Eigen::AngleAxisd turn(2 * std::numbers::pi * i / count, up);
    auto camera = Camera::look_at(target_ecef + turn * out, target_ecef, up, first.lens());
    if (!camera) return pass_on(camera);
    track.push_back(*camera);
  }
  return track;
}

Result<std::vector<Camera>> read_track(const std::string& file, double rate, const Lens& lens) {
  auto points = read_points(file);
  if (!points) return pass_on(points);
  const double start = points->front().seconds, end = points->back().seconds;
  const double count = std::floor((end - start) * rate + 1e-9) + 1;
  if (!(count <= static_cast<double>(kLongestTrack))) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} pictures are more than the {} one "
                                                 "request takes: ask for parts of the path",
                                                 file, count, kLongestTrack));
  }
  std::vector<Camera> track;
  std::size_t from = 0;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const double at = start + i / rate;
    while (from + 2 < points->size() && (*points)[from + 1].seconds <= at) ++from;
    const TrackPoint& a = (*points)[from];
    const TrackPoint& b = (*points)[std::min(from + 1, points->size() - 1)];
    const double span = b.seconds - a.seconds;
    const double part = span > 0 ? std::clamp((at - a.seconds) / span, 0.0, 1.0) : 0;
    const Eigen::Vector3d eye = a.eye_ecef + part * (b.eye_ecef - a.eye_ecef);
    const Eigen::Vector3d target = a.target_ecef + part * (b.target_ecef - a.target_ecef);
    auto camera = Camera::look_at(eye, target, up_at(eye), lens);
    if (!camera) return pass_on(camera, fmt::format("{}: at {} s", file, at));
    track.push_back(*camera);
  }
  return track;
}

}  // namespace voxatlas
