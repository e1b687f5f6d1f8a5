// The simulated flash sequencer's pins, beside trains that are worked out by hand.
#include "sim/flash_sequencer/board.hpp"

#include <vector>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::flash_sequencer;
using strobe::sim::RigLine;
using strobe::sim::sequencer::Board;
using strobe::sim::sequencer::PinChange;

namespace {

constexpr MonoTime kPowerUp = MonoTime{} + std::chrono::seconds(1000);

}  // namespace

TEST_GROUP(SequencerBoard) {
  Board board{5};
  std::vector<Edge> movers{{1000, bit(OutputLine::shutter)}, {2000, 0}};
  std::vector<Edge> lamps{{1500, bit(OutputLine::strobe_a)}, {100, 0}, {400, bit(OutputLine::strobe_b)}, {50, 0}};

  void setup() override {
    board.power_up(kPowerUp);
    board.line_changed(RigLine::key, 1, kPowerUp);
    board.line_changed(RigLine::estop, 1, kPowerUp);
    CHECK(board.release());
    board.prepare(movers, lamps);
  }
  MonoTime at(Ticks ticks) const { return board.instant(ticks); }
  void check_changes(const std::vector<PinChange>& expected) {
    const auto found = board.take_pin_changes();
    CHECK_EQUAL(expected.size(), found.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(expected[i].line == found[i].line);
      CHECK_EQUAL(expected[i].level, found[i].level);
      CHECK_EQUAL((expected[i].at - kPowerUp).count(), (found[i].at - kPowerUp).count());
    }
  }
};

TEST(SequencerBoard, ItsClockIsOffByAFewPartsInAMillionAndGoesBothWays) {
  const Duration hour = std::chrono::hours(1);
  const auto ticks = static_cast<double>(board.ticks(kPowerUp + hour));
  const double off_ppm = 1e6 * (ticks / (static_cast<double>(hour.count()) / 8.0) - 1.0);
  CHECK(off_ppm != 0.0 && off_ppm >= -Board::kMaxDrift_ppm && off_ppm <= Board::kMaxDrift_ppm);
  // The instant is the first nanosecond at which the clock shows the ticks; 2^53 of them have no rounding.
  for (const Ticks each : {Ticks{0}, Ticks{1}, Ticks{12'345}, Ticks{450'000'000'001}}) {
    const Ticks back = board.ticks(board.instant(each));
    CHECK(back == each || back == each - 1);
  }
}

TEST(SequencerBoard, PlaysBothTracksToTheTick) {
  board.start(100'000, false);
  CHECK_EQUAL((at(101'000) - kPowerUp).count(), (board.next_edge() - kPowerUp).count());
  board.advance(at(200'000) + Duration{1});
  check_changes({{at(101'000), RigLine::shutter, 1},
                 {at(101'500), RigLine::strobe_a, 1},
                 {at(101'600), RigLine::strobe_a, 0},
                 {at(102'000), RigLine::strobe_b, 1},
                 {at(102'050), RigLine::strobe_b, 0},
                 {at(103'000), RigLine::shutter, 0}});
  CHECK_EQUAL(2, board.progress().played[0]);
  CHECK_EQUAL(4, board.progress().played[1]);
  CHECK_EQUAL(100'000, board.progress().started);
  CHECK_EQUAL(100'000, board.progress().burst_started);
}

TEST(SequencerBoard, TheGateBeginsTheLampsTrackWhileItIsListenedTo) {
  board.start(100'000, true);
  board.line_changed(RigLine::gate, 1, at(100'100));
  board.line_changed(RigLine::gate, 0, at(100'200));
  board.listen_to_gate(true);
  board.line_changed(RigLine::gate, 1, at(100'300) + Duration{1});
  board.listen_to_gate(false);
  board.advance(at(200'000));
  CHECK_EQUAL(100'300, board.progress().burst_started);
  const auto changes = board.take_pin_changes();
  CHECK_EQUAL(std::size_t{6}, changes.size());
  CHECK_EQUAL((at(101'800) - kPowerUp).count(), (changes[1].at - kPowerUp).count());
}

TEST(SequencerBoard, KeyAndEstopCutAtTheirInstantAndItTakesARelease) {
  for (const RigLine line : {RigLine::key, RigLine::estop}) {
    setup();
    board.start(100'000, false);
    board.line_changed(line, 0, at(101'550) + Duration{1});
    check_changes({{at(101'000), RigLine::shutter, 1},
                   {at(101'500), RigLine::strobe_a, 1},
                   {at(101'550) + Duration{1}, RigLine::shutter, 0},
                   {at(101'550) + Duration{1}, RigLine::strobe_a, 0}});
    CHECK_EQUAL(line == RigLine::key ? CutCause::key : CutCause::estop, board.cut_by_itself());
    board.line_changed(line, 1, at(101'560));
    board.advance(at(200'000));
    check_changes({});
    CHECK(board.cut_by_itself() != CutCause::none);
    CHECK_TRUE(board.release());
    CHECK_EQUAL(CutCause::none, board.cut_by_itself());
  }
}

TEST(SequencerBoard, SensorsAndGateTellTheirActiveEdgesAndTheOthersBoth) {
  InputEdge edge;
  while (board.pop_input(edge)) continue;
  for (const RigLine line : {RigLine::sensor_a, RigLine::xsync}) {
    board.line_changed(line, 1, at(5000) + Duration{1});
    board.line_changed(line, 1, at(5500));
    board.line_changed(line, 0, at(6000) + Duration{1});
  }
  CHECK(board.pop_input(edge));
  CHECK_EQUAL(InputLine::sensor_a, edge.line);
  CHECK_EQUAL(1, edge.active);
  CHECK_EQUAL(5000, edge.time);
  CHECK(board.pop_input(edge));
  CHECK_EQUAL(InputLine::xsync, edge.line);
  CHECK(board.pop_input(edge));
  CHECK_EQUAL(0, edge.active);
  CHECK_FALSE(board.pop_input(edge));
}
