// The shipped firmware on a real kernel's GPIO driver. Its processor is emulated: order, counts and levels
// are judged, never times.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/kernel/kernel_fixture.hpp"
#include "tests/sim/gpiochip/conformance/requests.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::kernel;
using testing::CompletedProcess;

namespace {

constexpr int kFlashes = 20;  // of rig.toml's plan: 2600 ms, one each 130 ms
constexpr int kMidTrain = 10;
constexpr int kLongTrain = 75;  // 10 s, one each 130 ms: 76

std::vector<nlohmann::json> readouts_in(const std::string& out) {
  std::vector<nlohmann::json> found = testing::parse_json_lines(out);
  std::erase_if(found, [](const nlohmann::json& line) { return !line.contains("vx_td_mps"); });
  return found;
}

bool has_flag(const nlohmann::json& readout, const std::string& flag) {
  const auto& flags = readout.at("flags");
  return std::find(flags.begin(), flags.end(), flag) != flags.end();
}

/// The firmware itself says that it could not play the shot as planned.
bool was_disturbed(const nlohmann::json& readout) {
  for (const char* flag :
       {"shot_aborted", "missing_flash", "double_flash", "sensor_missing", "no_photograph", "late_flash"})
    if (has_flag(readout, flag)) return true;
  return false;
}

/// What one lamp and its sensor did in one shot: from the shutter's line going up to the next time it does.
struct Course {
  int flashes = 0, sensor_edges = 0, effects_without_cause = 0;
};

/// One for each shot; [0]: what came before the first.
std::vector<Course> courses_of(const std::vector<LineEvent>& events, Pin strobe, Pin sensor) {
  std::vector<Course> courses(1);
  for (const LineEvent& event : events) {
    if (event.level != 1) continue;
    if (event.pin == Pin::shutter) courses.emplace_back();
    Course& course = courses.back();
    if (event.pin == strobe) ++course.flashes;
    if (event.pin == sensor && ++course.sensor_edges > course.flashes) ++course.effects_without_cause;
  }
  return courses;
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
  std::optional<KernelFixture> bench{std::in_place, boot_folder()};

  void start(const std::string& program = "strobed") {
    if (!bench->start_strobed(program)) FAIL(("strobed is not ready: " + bench->strobed_log()).c_str());
  }

  void boot() {
    bench.reset();
    bench.emplace(boot_folder());
  }

  testing::Command fire(int shots, int retries = 0) const {
    return bench->strobe({"fire", "--shots", std::to_string(shots), "--retries", std::to_string(retries),
                          "--json", "--session", (bench->folder() / "session").string()});
  }

  /// Fires a train of 10 s, and waits until it is under way; again, if a machine that stood still ended it.
  std::unique_ptr<testing::Process> fire_and_wait_for_the_train() {
    testing::Command command = fire(1);
    const std::filesystem::path plan = bench->folder() / "plan.toml";
    testing::write_text(
        plan, "train = \"free\"\nperiod_us = 130000\nshutter_open_ms = 10000\nimpact_at_ms = 1300\n");
    command.arguments.insert(command.arguments.end(), {"--plan", plan.string()});
    for (int attempt = 0; attempt < 3; ++attempt) {
      auto firing = std::make_unique<testing::Process>(command, bench->folder());
      testing::wait_until([&] { return under_way() || !firing->running(); }, kTimeout);
      if (under_way()) return firing;
    }
    FAIL(("no train: " + bench->strobed_log()).c_str());
    return nullptr;
  }

  bool under_way() const { return bench->rises(Pin::strobe_a) >= kMidTrain; }

  /// Edges that come faster than the processor takes interrupts are one edge.
  void drive_and_let_it_see(Pin pin, int level) {
    bench->drive(pin, level);
    testing::wait_until([this] { return bench->scheduled_drives() == 0; }, kTimeout);
    bench->machine().run(":");
  }

  /// Edges as fast as the lines can be driven, so that some fall together for the kernel; on a quick host nearly all
  /// of them, unless the machine has answered now and then.
  void flood(Pin pin, const std::vector<int>& levels, int times) {
    constexpr int kBurst = 15;
    for (int i = 0; i < times; i += kBurst) {
      for (int k = i; k < std::min(i + kBurst, times); ++k)
        for (const int level : levels) bench->drive(pin, level);
      drive_and_let_it_see(pin, levels.back());
    }
  }

  void take_the_driver_away() {
    bench->machine().run("cd /sys/bus/amba/drivers/pl061_gpio && echo *.pl061 >unbind; cd /");
  }

  /// Debian's kernel itself panics in some of the cases where a driver goes whose lines are held, and its machine with
  /// it: tried again on another one.
  void on_a_kernel_that_survives(const std::function<void()>& trial) {
    for (int attempt = 0; attempt < 4; ++attempt) {
      try {
        return trial();
      } catch (const PeerGone&) {
        std::printf("the machine is gone:\n%s\n", bench->machine().log().c_str());
        boot();
      }
    }
    FAIL("the machine ended each time that its driver was taken away");
  }

  /// Whatever strobed was doing: of a shot that a standing machine has ended early nothing is left to fail.
  void strobed_ends() {
    CHECK_TRUE_TEXT(
        testing::wait_until([this] { return bench->machine().run("pidof strobed").empty(); }, kTimeout),
        (bench->strobed_log() + bench->machine().log()).c_str());
  }

  /// What a program of the conformance test printed, each of its requests carried out; `chip`: as it wants it
  /// named.
  std::string answers_to(const std::string& program, const std::string& chip) {
    VirtualMachine& machine = bench->machine();
    machine.run("mkfifo /tmp/answers; " + program + " " + chip + " 0 1 4 /tmp/answers >/tmp/out 2>&1 &");
    std::size_t done = 0;
    CHECK_TRUE(testing::wait_until(
        [&] {
          const auto requests = testing::conformance::requests_in(machine.run("cat /tmp/out"));
          if (requests.size() > done) {
            const auto& request = requests[done++];
            const Pin pin = request.line == 'B' ? Pin::strobe_b : Pin::sensor_a;
            if (request.times > 1)
              flood(pin, request.levels, request.times);
            else
              for (const int level : request.levels) drive_and_let_it_see(pin, level);
            if (request.unplug) take_the_driver_away();
            machine.run(": >/tmp/answers");
          }
          return machine.run("pidof " + std::filesystem::path(program).filename().string()).empty();
        },
        kTimeout));
    return machine.run("cat /tmp/out");
  }

  void outputs_become_inactive() {
    CHECK_TRUE_TEXT(testing::wait_until([this] { return outputs_inactive(bench->events()); }, kTimeout),
                    (bench->strobed_log() + bench->machine().log()).c_str());
  }

  void whole_shots_are_fired(const std::string& program) {
    // A machine that stands still for long ends a shot as flagged, and stamps that are some milliseconds off
    // against the ball's flight leave numbers ambiguous: such a shot is fired again.
    start(program);
    const CompletedProcess fired = testing::run_process(fire(2, 2), kTimeout);
    const auto readouts = readouts_in(fired.out);
    const std::string said = fired.out + fired.err + bench->strobed_log();
    CHECK_TRUE_TEXT(readouts.size() >= 2, said.c_str());
    const auto events = bench->events();
    const auto a = courses_of(events, Pin::strobe_a, Pin::sensor_a);
    const auto b = courses_of(events, Pin::strobe_b, Pin::sensor_b);
    CHECK_TRUE_TEXT(a.size() == readouts.size() + 1 && b.size() == a.size(), said.c_str());
    LONGS_EQUAL(0, a[0].flashes + b[0].flashes);
    int whole = 0;
    for (std::size_t shot = 1; shot < a.size(); ++shot) {
      const nlohmann::json& readout = readouts[shot - 1];
      std::printf("shot %zu: flashes %d and %d, sensors %d and %d, vx %s m/s, flags %s\n", shot,
                  a[shot].flashes, b[shot].flashes, a[shot].sensor_edges, b[shot].sensor_edges,
                  readout.at("vx_td_mps").dump().c_str(), readout.at("flags").dump().c_str());
      LONGS_EQUAL(shot, readout.at("shot_id").get<int>());
      LONGS_EQUAL(0, a[shot].effects_without_cause + b[shot].effects_without_cause);
      LONGS_EQUAL(a[shot].flashes, b[shot].flashes);
      if (was_disturbed(readout)) continue;
      ++whole;
      for (const int count : {a[shot].flashes, a[shot].sensor_edges, b[shot].sensor_edges})
        CHECK_TRUE_TEXT(count == kFlashes, said.c_str());
    }
    CHECK_TRUE_TEXT(whole >= 1, said.c_str());
    CHECK_TRUE(bench->rises(Pin::trigger) <= static_cast<int>(readouts.size()));
    CHECK_TRUE(bench->rises(Pin::trigger) >= whole);
    outputs_become_inactive();
  }

  void an_emergency_stop_in_mid_train_stops(const std::string& program) {
    start(program);
    bench->drive_at_flash(kMidTrain, Pin::estop, 0);
    const auto firing = fire_and_wait_for_the_train();
    outputs_become_inactive();
    firing->wait(kTimeout);
    const auto events = bench->events();
    const std::size_t pressed = place_of(events, Pin::estop, 0);
    // An edge that was on its way when the line fell, and no more.
    CHECK_TRUE(rises_after(events, pressed) <= 2);
    CHECK_TRUE(bench->rises(Pin::strobe_a) < kLongTrain);
    CHECK_TRUE(outputs_inactive(bench->events()));
  }
};

TEST(RealKernel, SystemCallsAreAnsweredAsOnTheSimulatedChip) {
  const std::string answers = bench->machine().run("gpio_kernel_calls /dev/gpiochip0 0 1");
  CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls.txt"), answers);
}

TEST(RealKernel, SystemCallsOfVersion2AreAnsweredAsOnTheSimulatedChip) {
  on_a_kernel_that_survives([&] {
    const std::string out = answers_to("gpio_kernel_calls_v2", "/dev/gpiochip0");
    CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_kernel_calls_v2.txt"), out);
  });
}

TEST(RealKernel, TheFirmwaresGpioChipIsAnsweredAsOnTheSimulatedChip) {
  for (const char* program : {"gpio_chip_calls", "/gpiod2/gpio_chip_calls"})
    on_a_kernel_that_survives([&] {
      if (bench->machine().run("ls /dev/gpiochip0 2>/dev/null").empty()) boot();
      const std::string out = answers_to(program, "gpiochip0 9030000.pl061");
      CHECK_EQUAL(testing::read_text(STROBE_TEST_DATA "/gpio_chip_calls.txt"), out);
    });
}

TEST(RealKernel, WholeShotsAreFiredAndReadOutByTheHostOutside) { whole_shots_are_fired("strobed"); }

TEST(RealKernel, WholeShotsAreFiredWithLibgpiod2Too) { whole_shots_are_fired("/gpiod2/strobed"); }

TEST(RealKernel, OutputsAreInactiveAfterAnEmergencyStopInTheMiddleOfATrain) {
  an_emergency_stop_in_mid_train_stops("strobed");
}

TEST(RealKernel, OutputsAreInactiveAfterAnEmergencyStopWithLibgpiod2Too) {
  an_emergency_stop_in_mid_train_stops("/gpiod2/strobed");
}

TEST(RealKernel, OutputsAreInactiveAfterTheWorkerWasKilledInTheMiddleOfATrain) {
  start();
  const auto firing = fire_and_wait_for_the_train();
  bench->machine().run("for p in $(pidof strobed); do [ $p = $(cat /tmp/pid) ] || kill -9 $p; done");
  outputs_become_inactive();
  const std::size_t safe = bench->events().size();
  strobed_ends();
  STRCMP_CONTAINS("the guardian made the outputs inactive", bench->strobed_log().c_str());
  const auto events = bench->events();
  LONGS_EQUAL(0, rises_after(events, safe));
  CHECK_TRUE(bench->rises(Pin::strobe_a) < kLongTrain);
  firing->signal(SIGTERM);
}

TEST(RealKernel, OutputsAreMadeInactiveByHandAfterWorkerAndGuardianWereKilled) {
  start();
  const auto firing = fire_and_wait_for_the_train();
  bench->machine().run("kill -9 $(pidof strobed); while pidof strobed >/dev/null; do :; done");
  CHECK_EQUAL("0\n", bench->machine().run("strobed --safe --config /rig.toml; echo $?"));
  outputs_become_inactive();
  const std::size_t safe = bench->events().size();
  bench->machine().run("sleep 1");
  LONGS_EQUAL(0, rises_after(bench->events(), safe));
  CHECK_TRUE(bench->rises(Pin::strobe_a) < kLongTrain);
  firing->signal(SIGTERM);
}

TEST(RealKernel, EndsAsFailedWhenTheDriverIsTakenAwayInTheMiddleOfATrain) {
  on_a_kernel_that_survives([this] {
    start();
    const auto firing = fire_and_wait_for_the_train();
    take_the_driver_away();
    strobed_ends();
    CHECK_TRUE(bench->rises(Pin::strobe_a) < kLongTrain);
    firing->signal(SIGTERM);
  });
}

TEST(RealKernel, EndsAsFailedWhenTheDriverIsTakenAwayThoughNothingIsFired) {
  on_a_kernel_that_survives([this] {
    start();
    take_the_driver_away();
    strobed_ends();
    STRCMP_CONTAINS("THE OUTPUTS MAY BE ACTIVE", bench->strobed_log().c_str());
  });
}
