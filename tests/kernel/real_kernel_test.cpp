// The shipped firmware on a real kernel's GPIO driver. Its processor is emulated: order, counts and levels
// are judged, never times.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/kernel/emulated_bench.hpp"
#include "tests/sim/gpiochip/conformance/requests.hpp"
#include "tests/support/json_lines.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::kernel;
using testing::ExitStatus;
using testing::Finished;

namespace {

constexpr int kFlashes = 30;  // of rig.toml's plan: 1200 ms, one each 40 ms
constexpr int kMidTrain = 10;

std::vector<nlohmann::json> readouts_in(const std::string& out) {
  std::vector<nlohmann::json> found = testing::parse_json_lines(out);
  std::erase_if(found, [](const nlohmann::json& line) { return !line.contains("vx_td_mps"); });
  return found;
}

bool has_flag(const nlohmann::json& readout, const std::string& flag) {
  const auto& flags = readout.at("flags");
  return std::find(flags.begin(), flags.end(), flag) != flags.end();
}

/// Flashes of one lamp while the shutter was open, and outside of that; sensors' edges without a flash
/// before.
struct Course {
  int in_exposure = 0;
  int outside = 0;
  int sensor_edges = 0;
  int effects_without_cause = 0;
};

Course course_of(const std::vector<LineEvent>& events, Pin strobe, Pin sensor) {
  Course course;
  bool open = false;
  int flashes = 0;
  for (const LineEvent& event : events) {
    if (event.pin == Pin::shutter) open = event.level == 1;
    if (event.level != 1) continue;
    if (event.pin == strobe) {
      ++flashes;
      ++(open ? course.in_exposure : course.outside);
    }
    if (event.pin == sensor && ++course.sensor_edges > flashes) ++course.effects_without_cause;
  }
  return course;
}

int rises_after(const std::vector<LineEvent>& events, std::size_t from) {
  return static_cast<int>(std::count_if(
      events.begin() + static_cast<std::ptrdiff_t>(from), events.end(), [](const LineEvent& event) {
        return static_cast<unsigned>(event.pin) < kOutputPins && event.level == 1;
      }));
}

std::size_t place_of(const std::vector<LineEvent>& events, Pin pin, int level) {
  const auto found = std::find_if(events.rbegin(), events.rend(), [&](const LineEvent& event) {
    return event.pin == pin && event.level == level;
  });
  return static_cast<std::size_t>(events.rend() - found);
}

}  // namespace

TEST_GROUP(RealKernel) {
  EmulatedBench bench{STROBE_KERNEL_BOOT};

  void start() {
    if (!bench.start_strobed()) FAIL(("strobed is not ready: " + bench.strobed_log()).c_str());
  }

  testing::Command fire(int shots, int retries = 0) const {
    return bench.strobe({"fire", "--shots", std::to_string(shots), "--retries", std::to_string(retries),
                         "--json", "--session", (bench.folder() / "session").string()});
  }

  /// Fires, and waits until the train is under way.
  std::unique_ptr<testing::Process> fire_and_wait_for_the_train() {
    auto firing = std::make_unique<testing::Process>(fire(1), bench.folder());
    CHECK_TRUE_TEXT(
        testing::wait_until([&] { return bench.rises(Pin::strobe_a) >= kMidTrain || !firing->running(); },
                            kPatience),
        "no train");
    return firing;
  }

  /// Edges that come faster than the processor takes interrupts are one edge.
  void drive_and_let_it_see(Pin pin, int level) {
    bench.drive(pin, level);
    testing::wait_until([this] { return bench.orders_left() == 0; }, kPatience);
    bench.machine().run(":");
  }

  void take_the_driver_away() {
    bench.machine().run("cd /sys/bus/amba/drivers/pl061_gpio && echo *.pl061 >unbind; cd /");
  }

  void outputs_become_inactive() {
    CHECK_TRUE_TEXT(testing::wait_until([this] { return outputs_inactive(bench.events()); }, kPatience),
                    (bench.strobed_log() + bench.machine().log()).c_str());
  }
};

TEST(RealKernel, SystemCallsAreAnsweredAsOnTheSimulatedChip) {
  const std::string answers = bench.machine().run("gpio_kernel_calls /dev/gpiochip0 0 1");
  STRCMP_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls.txt").c_str(), answers.c_str());
}

TEST(RealKernel, LibgpiodIsAnsweredAsOnTheSimulatedChip) {
  VirtualMachine& machine = bench.machine();
  machine.run("mkfifo /tmp/answers; gpio_library_calls gpiochip0 0 1 4 /tmp/answers >/tmp/out 2>&1 &");
  std::size_t done = 0;
  std::string out;
  CHECK_TRUE(testing::wait_until(
      [&] {
        out = machine.run("cat /tmp/out");
        const auto requests = testing::conformance::requests_in(out);
        if (requests.size() > done) {
          const auto& request = requests[done++];
          for (const int level : request.levels) drive_and_let_it_see(Pin::sensor_a, level);
          if (request.unplug) take_the_driver_away();
          machine.run(": >/tmp/answers");
        }
        return machine.run("pidof gpio_library_calls").empty();
      },
      kPatience));
  out = machine.run("cat /tmp/out");
  STRCMP_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_library_calls.txt").c_str(), out.c_str());
}

TEST(RealKernel, WholeShotsAreFiredAndReadOutByTheHostOutside) {
  // Stamps that are a millisecond off against the ball's flight may leave numbers in doubt: that shot is
  // fired again, and nothing else about it may be wrong.
  start();
  const Finished fired = testing::run_to_end(fire(2, 1), kPatience);
  const auto readouts = readouts_in(fired.out);
  const int shots = static_cast<int>(readouts.size());
  CHECK_TRUE_TEXT(shots >= 2, (fired.out + fired.err + bench.strobed_log()).c_str());
  for (int shot = 0; shot < shots; ++shot) {
    const nlohmann::json& readout = readouts[static_cast<std::size_t>(shot)];
    LONGS_EQUAL(shot + 1, readout.at("shot_id").get<int>());
    for (const char* flag :
         {"missing_flash", "double_flash", "sensor_missing", "shot_aborted", "no_photograph"}) {
      CHECK_TRUE_TEXT(!has_flag(readout, flag), readout.dump().c_str());
    }
    std::printf("shot %d: vx %s m/s, e %s, flags %s\n", shot + 1, readout.at("vx_td_mps").dump().c_str(),
                readout.at("e").dump().c_str(), readout.at("flags").dump().c_str());
  }
  const auto events = bench.events();
  for (const auto& [strobe, sensor] :
       {std::pair{Pin::strobe_a, Pin::sensor_a}, {Pin::strobe_b, Pin::sensor_b}}) {
    const Course course = course_of(events, strobe, sensor);
    LONGS_EQUAL(shots * kFlashes, course.in_exposure);
    LONGS_EQUAL(0, course.outside);
    LONGS_EQUAL(shots * kFlashes, course.sensor_edges);
    LONGS_EQUAL(0, course.effects_without_cause);
  }
  LONGS_EQUAL(shots, bench.rises(Pin::shutter));
  LONGS_EQUAL(shots, bench.rises(Pin::trigger));
  outputs_become_inactive();
}

TEST(RealKernel, OutputsAreInactiveAfterAnEmergencyStopInTheMiddleOfATrain) {
  start();
  bench.drive_at_flash(kMidTrain, Pin::estop, 0);
  const auto firing = fire_and_wait_for_the_train();
  outputs_become_inactive();
  firing->wait(kPatience);
  const auto events = bench.events();
  const std::size_t pressed = place_of(events, Pin::estop, 0);
  // An edge that was on its way when the line fell, and no more.
  CHECK_TRUE(rises_after(events, pressed) <= 2);
  CHECK_TRUE(bench.rises(Pin::strobe_a) < kFlashes);
  CHECK_TRUE(outputs_inactive(bench.events()));
}

TEST(RealKernel, OutputsAreInactiveAfterTheWorkerWasKilledInTheMiddleOfATrain) {
  start();
  const auto firing = fire_and_wait_for_the_train();
  bench.machine().run("for p in $(pidof strobed); do [ $p = $(cat /tmp/pid) ] || kill -9 $p; done");
  outputs_become_inactive();
  const std::size_t safe = bench.events().size();
  CHECK_TRUE(testing::wait_until([this] { return bench.machine().run("pidof strobed").empty(); }, kPatience));
  STRCMP_CONTAINS("the guardian made the outputs inactive", bench.strobed_log().c_str());
  const auto events = bench.events();
  LONGS_EQUAL(0, rises_after(events, safe));
  CHECK_TRUE(bench.rises(Pin::strobe_a) < kFlashes);
  firing->signal(SIGTERM);
}

TEST(RealKernel, OutputsAreMadeInactiveByHandAfterWorkerAndGuardianWereKilled) {
  start();
  const auto firing = fire_and_wait_for_the_train();
  bench.machine().run("kill -9 $(pidof strobed); while pidof strobed >/dev/null; do :; done");
  STRCMP_EQUAL("0\n", bench.machine().run("strobed --safe --config /rig.toml; echo $?").c_str());
  outputs_become_inactive();
  const std::size_t safe = bench.events().size();
  bench.machine().run("sleep 1");
  LONGS_EQUAL(0, rises_after(bench.events(), safe));
  CHECK_TRUE(bench.rises(Pin::strobe_a) < kFlashes);
  firing->signal(SIGTERM);
}

TEST(RealKernel, EndsAsFailedWhenTheDriverIsTakenAwayInTheMiddleOfATrain) {
  start();
  const auto firing = fire_and_wait_for_the_train();
  take_the_driver_away();
  CHECK_TRUE(testing::wait_until([this] { return bench.machine().run("pidof strobed").empty(); }, kPatience));
  const int flashes = bench.rises(Pin::strobe_a);
  CHECK_TRUE(flashes < kFlashes);
  firing->signal(SIGTERM);
}
