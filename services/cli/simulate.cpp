#include "cli/simulate.hpp"

#include <fmt/format.h>

#include "bus/service_loop.hpp"
#include "cli/progress.hpp"
#include "cli/scan_input.hpp"
#include "io/kitti_writer.hpp"

namespace voxatlas {

Status run_simulate(const SimulateOptions& options) {
  auto input = open_simulated(options.drive);
  if (!input) return pass_on(input);
  auto writer = KittiWriter::create(options.out);
  if (!writer) return pass_on(writer);
  Progress progress;
  for (std::size_t i = 0; i < options.drive.scans; ++i) {
    if (stop_requested()) {
      return fail(ErrorCode::kUnavailable,
                  fmt::format("stopped after {} of {} scans; {} holds them whole", i,
                              options.drive.scans, options.out));
    }
    auto scan = input->read(i);
    if (!scan) return pass_on(scan);
    if (auto written = writer->write(scan->scan); !written) return written;
    progress.say(fmt::format("{} of {} scans written", i + 1, options.drive.scans));
  }
  fmt::print("{} scans in {}; publish them: voxatlas publish {} --poses poses.txt\n",
             writer->written(), options.out, options.out);
  return {};
}

}  // namespace voxatlas
