// Resistors of the chip, and wires that break.
#include <linux/gpio.h>
#include <signal.h>

#include "tests/sim/gpiochip/fixture.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

namespace {

constexpr std::uint32_t kKey = 7;
constexpr std::uint32_t kEStop = 8;
const std::string kPullUp = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_PULL_UP);
const std::string kPullDown = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_PULL_DOWN);
const std::string kNoBias = std::to_string(GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_DISABLE);
const std::string kAsIs = std::to_string(GPIOHANDLE_REQUEST_INPUT);
const std::string kBothEdges = "3";
const std::string kDown = "0";  // of the actor for uAPI v2
const std::string kUp = "1";

ChipSpec chip_with(Bias bias, int reset_pull) {
  ChipSpec spec = standard_chip();
  spec.bias = bias;
  for (LineSpec& line : spec.lines) line.reset_pull = reset_pull;
  return spec;
}

}  // namespace

TEST_GROUP(OpenWires) {
  ChipFixture fixture;

  static int level(ChipFixture & chip, std::uint32_t line) { return chip.chip().state(line).level; }
  /// By uAPI v1.
  static testing::Process reader(ChipFixture & chip, std::uint32_t line, const std::string& flags) {
    return chip.actor({"events", std::to_string(line), kBothEdges, flags});
  }
  static testing::Process reader_v2(ChipFixture & chip, std::uint32_t line, const std::string& bias) {
    return chip.actor({"pulled", std::to_string(line), bias}, "ready", "gpio_actor_v2");
  }
};

TEST(OpenWires, KeepTheirLevelWhereNothingPulls) {
  fixture.chip().open_wire(kKey, now());
  fixture.chip().open_wire(0, now());
  LONGS_EQUAL(1, level(fixture, kKey));
  LONGS_EQUAL(0, level(fixture, 0));
}

TEST(OpenWires, AreReadByTheResistorThatTheyHadAtReset) {
  ChipFixture pulled(chip_with(Bias::set, 1));
  LONGS_EQUAL(0, level(pulled, 0));  // held from outside
  pulled.chip().open_wire(0, now());
  LONGS_EQUAL(1, level(pulled, 0));
  const auto holder = reader(pulled, 0, kAsIs);
  LONGS_EQUAL(1, level(pulled, 0));
  pulled.chip().drive(0, 0, now());
  LONGS_EQUAL(0, level(pulled, 0));
}

TEST(OpenWires, AreReadByTheBiasOfTheirRequestOfEitherVersion) {
  ChipFixture chip(chip_with(Bias::set, 1));
  for (const std::uint32_t line : {kKey, kEStop, 0U, 1U}) chip.chip().open_wire(line, now());
  const auto key = reader(chip, kKey, kPullDown);
  const auto estop = reader_v2(chip, kEStop, kDown);
  const auto first = reader(chip, 0, kPullUp);
  const auto second = reader_v2(chip, 1, kUp);
  STRCMP_CONTAINS("ready 0", estop.out().c_str());
  STRCMP_CONTAINS("ready 1", second.out().c_str());
  LONGS_EQUAL(0, level(chip, kKey));
  LONGS_EQUAL(0, level(chip, kEStop));
  LONGS_EQUAL(1, level(chip, 0));
}

TEST(OpenWires, DoNotMoveALineThatIsHeldFromOutside) {
  const auto key = reader(fixture, kKey, kPullDown);
  const auto estop = reader_v2(fixture, kEStop, kDown);
  LONGS_EQUAL(1, level(fixture, kKey));
  LONGS_EQUAL(1, level(fixture, kEStop));
}

TEST(OpenWires, KeepABiasThatOutlivesItsRequest) {
  {
    auto holder = reader(fixture, kKey, kPullDown);
    holder.signal(SIGKILL);
    holder.wait(kLimit);
  }
  fixture.chip().open_wire(kKey, now());
  LONGS_EQUAL(0, level(fixture, kKey));
  const auto none = reader(fixture, kKey, kNoBias);
  fixture.chip().drive(kKey, 1, now());
  fixture.chip().open_wire(kKey, now());
  LONGS_EQUAL(1, level(fixture, kKey));
}

TEST(OpenWires, GiveAnEdgeWhenTheyBreakAndWhenTheyAreMended) {
  auto key = reader(fixture, kKey, kPullDown);
  fixture.chip().open_wire(kKey, now());
  fixture.chip().open_wire(kKey, now());  // no edge: it is open already
  fixture.chip().drive(kKey, 0, now());   // nor here
  fixture.chip().drive(kKey, 1, now());
  CHECK(key.wait_for_out("\n1 ", kLimit));
  const std::vector<int> seen = ChipFixture::levels(fixture.changes(2), kKey);
  CHECK_TRUE((std::vector<int>{0, 1}) == seen);
  STRCMP_CONTAINS("ready\n2 ", key.out().c_str());
}

TEST(OpenWires, AreNotPulledByAChipWithoutResistorsThoughItTellsSo) {
  ChipFixture chip(chip_with(Bias::ignored, -1));
  chip.chip().open_wire(kKey, now());
  chip.chip().open_wire(kEStop, now());
  const auto key = reader(chip, kKey, kPullDown);
  const auto estop = reader_v2(chip, kEStop, kDown);
  LONGS_EQUAL(1, level(chip, kKey));
  STRCMP_CONTAINS("ready 1", estop.out().c_str());
}

TEST(OpenWires, OfAChipThatRefusesABiasAreNotTaken) {
  ChipFixture chip(chip_with(Bias::refused, -1));
  for (const char* program : {"gpio_actor", "gpio_actor_v2"}) {
    const bool version2 = std::string(program) == "gpio_actor_v2";
    const std::vector<std::string> role =
        version2 ? std::vector<std::string>{"pulled", "7", kDown}
                 : std::vector<std::string>{"events", "7", kBothEdges, kPullDown};
    const auto refused = chip.actor(role, "EINVAL", program);
    CHECK_FALSE(chip.chip().state(kKey).requested);
    CHECK_EQUAL("", chip.chip().state(kKey).consumer);
  }
  const auto plain = reader(chip, kKey, kAsIs);
  CHECK_TRUE(chip.chip().state(kKey).requested);
}
