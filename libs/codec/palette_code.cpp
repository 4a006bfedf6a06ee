#include "codec/palette_code.hpp"

#include <algorithm>
#include <array>

namespace voxatlas {
namespace {

constexpr std::size_t kValues = 65'536;
constexpr std::size_t kMostValues = 65'535;

/// Which values there are, coded by what can follow from what.
///
/// From 0 on, in the order of their finding: is the value one hit higher there, is the one a miss
/// lower? Values that are not there are followed too, but not twice in a row. What is found by no
/// such step comes after, as 16 bits each.
template <class Coder>
class PaletteModel {
 public:
  /// `palette` is what to code, or empty and takes what is read, in no order.
  PaletteModel(Coder& coder, std::vector<LogOdds>& palette) : coder_(coder), palette_(palette) {
    for (const LogOdds value : palette) there_[slot(value)] = true;
  }

  void code() {
    find(0, false);
    for (std::size_t next = 0; next < found_.size(); ++next) {
      const auto [value, absent] = found_[next];
      for (const LogOdds step : {kModel.hit, kModel.miss}) {
        find(kModel.update(value, step), absent);
      }
    }
    code_others();
  }

  bool broken() const { return broken_; }

 private:
  struct Found {
    LogOdds value;
    bool absent;
  };

  /// The default model's steps: values of another model's cost 16 bits each.
  static constexpr SensorModel kModel{3471, -1661, -8161, 14'238};

  static std::size_t slot(LogOdds value) { return static_cast<std::uint16_t>(value); }

  void take(LogOdds value) {
    if (Coder::kDecodes) palette_.push_back(value);
  }

  void find(LogOdds value, bool from_absent) {
    if (asked_[slot(value)]) return;
    asked_[slot(value)] = true;
    const bool there = coder_.code(step_[from_absent ? 1 : 0], there_[slot(value)]);
    if (there) take(value);
    if (there || !from_absent) found_.push_back({value, !there});
  }

  /// What is left, rising: before each a 1, behind the last a 0.
  void code_others() {
    int last = INT16_MIN - 1;
    for (std::size_t next = 0;; ++next) {
      while (!Coder::kDecodes && next < palette_.size() && asked_[slot(palette_[next])]) ++next;
      const bool more = !Coder::kDecodes && next < palette_.size();
      if (!coder_.code(more_, more)) return;
      const unsigned truth = more ? static_cast<unsigned>(palette_[next] - INT16_MIN) : 0;
      int read = 0;
      for (unsigned k = 16; k-- > 0;) {
        read = 2 * read + (coder_.code(bits_[k], (truth >> k & 1) != 0) ? 1 : 0);
      }
      read += INT16_MIN;
      const auto value = static_cast<LogOdds>(read);
      if (read <= last || asked_[slot(value)]) {
        broken_ = true;
        return;
      }
      last = read;
      take(value);
    }
  }

  Coder& coder_;
  std::vector<LogOdds>& palette_;
  std::vector<bool> there_ = std::vector<bool>(kValues), asked_ = std::vector<bool>(kValues);
  std::vector<Found> found_;
  std::array<Chance, 2> step_;
  Chance more_;
  std::array<Chance, 16> bits_;
  bool broken_ = false;
};

}  // namespace

void code_palette(RangeEncoder& coder, const std::vector<LogOdds>& palette) {
  auto values = palette;
  PaletteModel(coder, values).code();
}

bool code_palette(RangeDecoder& coder, std::vector<LogOdds>& palette) {
  PaletteModel model(coder, palette);
  model.code();
  std::sort(palette.begin(), palette.end());
  return !model.broken() && !palette.empty() && palette.size() <= kMostValues;
}

}  // namespace voxatlas
