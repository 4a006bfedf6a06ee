#include "render/signs.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "geodesy/ecef.hpp"

namespace voxatlas {
namespace {

constexpr Rgb kInk{30, 34, 40}, kRed{208, 48, 40}, kGreen{40, 140, 60}, kBlue{40, 80, 200};
constexpr float kMarginPixels = 16, kTextPixels = 12;

/// Letters as polylines on a lattice of 3 columns (0..2) and 5 rows (0 at the foot); two digits a
/// point, a space lifts the pen.
struct Letter {
  char name;
  std::string_view lines;
};
constexpr std::array kLetters = {Letter{'0', "0020240400"},
                                 Letter{'1', "1014 1403"},
                                 Letter{'2', "042422020020"},
                                 Letter{'3', "04242000 0222"},
                                 Letter{'4', "0402 0222 2420"},
                                 Letter{'5', "240402222000"},
                                 Letter{'6', "240400202202"},
                                 Letter{'7', "042410"},
                                 Letter{'8', "0020240400 0222"},
                                 Letter{'9', "002024040222"},
                                 Letter{'.', "1011"},
                                 Letter{'N', "00042024"},
                                 Letter{'m', "0003 0312 1012 1223 2023"},
                                 Letter{'x', "0024 0420"},
                                 Letter{'y', "2400 0412"},
                                 Letter{'z', "04240020"}};
constexpr float kColumns = 3, kRows = 4;  // To the next letter; to a letter's top.

Eigen::Vector2f lattice(char column, char row) {
  return {static_cast<float>(column - '0'), -static_cast<float>(row - '0')};
}

/// An arrow whose tip has two barbs.
void add_arrow(Strokes& strokes, const Eigen::Vector2f& from, const Eigen::Vector2f& along,
               Rgb colour) {
  const Eigen::Vector2f tip = from + along;
  strokes.push_back({from, tip, colour});
  const Eigen::Vector2f across(-along.y(), along.x());
  for (const float side : {-0.12f, 0.12f}) {
    strokes.push_back({tip, tip - 0.25f * along + side * across, colour});
  }
}

}  // namespace

float add_text(Strokes& strokes, const std::string& text, const Eigen::Vector2f& corner,
               float height, Rgb colour) {
  const float unit = height / kRows;
  Eigen::Vector2f at = corner;
  for (const char name : text) {
    const auto letter = std::find_if(kLetters.begin(), kLetters.end(),
                                     [name](const Letter& l) { return l.name == name; });
    at.x() += kColumns * unit;
    if (letter == kLetters.end()) continue;
    const std::string_view lines = letter->lines;
    for (std::size_t i = 0; i + 3 < lines.size(); i += 2) {
      if (lines[i] == ' ') ++i;
      if (lines[i + 2] == ' ') continue;  // The end of a line.
      const Eigen::Vector2f left(at.x() - kColumns * unit, at.y());
      strokes.push_back({left + unit * lattice(lines[i], lines[i + 1]),
                         left + unit * lattice(lines[i + 2], lines[i + 3]), colour});
    }
  }
  return at.x() - corner.x();
}

Strokes axes_sign(const Camera& camera) {
  constexpr float kLength = 36;
  constexpr std::array<Rgb, 3> kColours = {kRed, kGreen, kBlue};
  const Eigen::Vector2f foot(kMarginPixels + kLength,
                             static_cast<float>(camera.height()) - kMarginPixels - kLength);
  Strokes strokes;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector2f along =
        kLength * camera.rotation().col(axis).head<2>().cast<float>();  // Right and down.
    const Rgb colour = kColours[static_cast<std::size_t>(axis)];
    add_arrow(strokes, foot, along, colour);
    const Eigen::Vector2f beside =
        foot + 1.2f * along + Eigen::Vector2f(-kTextPixels / 4, kTextPixels / 2);
    add_text(strokes, std::string(1, "xyz"[axis]), beside, kTextPixels * 0.75f, colour);
  }
  return strokes;
}

Strokes north_sign(const Camera& camera) {
  constexpr float kLength = 40;
  const Eigen::Vector3d up = up_at(camera.position());
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d north = axis - axis.dot(up) * up;  // At the poles every way leads from it.
  if (north.norm() < 1e-9) north = up.unitOrthogonal();
  const Eigen::Vector2f along =
      kLength * (camera.rotation() * north.normalized()).head<2>().cast<float>();
  const Eigen::Vector2f middle(static_cast<float>(camera.width()) - kMarginPixels - kLength / 2,
                               kMarginPixels + kLength / 2 + kTextPixels);
  Strokes strokes;
  add_arrow(strokes, middle - 0.5f * along, along, kInk);
  add_text(strokes, "N",
           middle + 0.75f * along + Eigen::Vector2f(-kTextPixels / 4, kTextPixels / 2), kTextPixels,
           kInk);
  return strokes;
}

double round_length(double limit) {
  const double ten = std::pow(10, std::floor(std::log10(limit)));
  constexpr double kSlack = 1 + 1e-9;
  for (const double part : {5.0, 2.0}) {
    if (part * ten <= limit * kSlack) return part * ten;
  }
  return ten;
}

Strokes scale_sign(const Camera& camera, const CellImage& cells) {
  const bool map = camera.orthographic();
  const double z =
      cells.z.empty()
          ? static_cast<double>(CellImage::kNowhere)
          : static_cast<double>(cells.z[cells.index(cells.width / 2, cells.height / 2)]);
  if (!map && !std::isfinite(z)) return {};  // Sky: no distance to be to scale at.
  const double pixels_a_metre = map ? camera.lens().fx : camera.lens().fx / z;
  const double metres = round_length(camera.width() / 4.0 / pixels_a_metre);
  const auto pixels = static_cast<float>(metres * pixels_a_metre);
  const Eigen::Vector2f right(static_cast<float>(camera.width()) - kMarginPixels,
                              static_cast<float>(camera.height()) - kMarginPixels);
  const Eigen::Vector2f left = right - Eigen::Vector2f(pixels, 0), tick(0, -6);
  Strokes strokes = {{left, right, kInk}, {left, left + tick, kInk}, {right, right + tick, kInk}};
  std::string text = fmt::format("{:g} m", metres);
  if (!map) text += fmt::format("   z {:.0f} m", z);
  const float width = add_text(strokes, text, {0, 0}, kTextPixels, kInk);
  const Eigen::Vector2f to(right.x() - width, right.y() - 10);
  for (std::size_t i = 3; i < strokes.size(); ++i) {
    strokes[i].from += to;
    strokes[i].to += to;
  }
  return strokes;
}

}  // namespace voxatlas
