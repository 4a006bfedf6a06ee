#include "compress/machine_load.hpp"

#include <catch2/catch.hpp>

namespace voxatlas {
namespace {

TEST_CASE("what waits or rests is not busy, what runs at a lowered priority is", "[compress]") {
  //                                             user nice sys idle iowait irq softirq steal
  const auto ticks = parse_processor_ticks("cpu  100  20   30 400  50     6   7       8 9 10");
  REQUIRE(ticks.has_value());
  CHECK(ticks->busy == 100 + 20 + 30 + 6 + 7 + 8);
  CHECK(ticks->all == 100 + 20 + 30 + 400 + 50 + 6 + 7 + 8);
}

TEST_CASE("load is what others keep busy", "[compress]") {
  const ProcessorTicks before{1000, 5000}, after{1150, 5200};
  CHECK(load_between(before, after, 0) == 0.75);
  CHECK(load_between(before, after, 50) == 0.5);
  CHECK(load_between(before, after, 151) == 0);  // Clocks that do not agree,
  CHECK(load_between(after, before, 0) == 0);    // go back,
  CHECK(load_between(after, after, 0) == 0);     // or stand.
}

TEST_CASE("what is no /proc/stat is not read as one", "[compress]") {
  for (const char* text : {"", "cpu ", "cpu 1 2 3", "cpu0 1 2 3 4 5 6 7 8", "cpu 1 2 x 4 5 6 7 8",
                           "cpu -1 2 3 4 5 6 7 8"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_processor_ticks(text).has_value());
  }
}

TEST_CASE("this machine's load is a share", "[compress]") {
  MachineLoad load;
  for (std::int64_t now = 0; now < 3'000'000; now += 100'000) {
    const double share = load.now(now);
    CHECK(share >= 0);
    CHECK(share <= 1);
  }
}

}  // namespace
}  // namespace voxatlas
