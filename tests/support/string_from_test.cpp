#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/floating_point_traps.hpp"
#include "tests/support/host_bench.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using strobe::testing::error_of;
using strobe::testing::ManualClock;
using strobe::testing::RememberingBus;
using strobe::testing::FloatingPointTraps;
using strobe::testing::raises_exception;

namespace {

enum class Colour { red, green = 5, far = 1000 };

struct Point {
  int x = 0;
  friend std::ostream& operator<<(std::ostream& stream, const Point& point) {
    return stream << "x=" << point.x;
  }
};
struct Unprintable {};

/// The signal that ends a child which makes the call under traps, 0 if it lives.
int signal_of(const std::function<double(double)>& call, double argument) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGFPE, SIG_DFL);  // not the handler of a sanitizer
    const FloatingPointTraps traps;
    volatile double result = call(argument);
    static_cast<void>(result);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

}  // namespace

TEST_GROUP(StringFrom){template <typename T> void expect(const char* text, const T& value){
    STRCMP_EQUAL(text, StringFrom(value).asCharString());
}
}
;

TEST(StringFrom, NamesEnumerators) {
  expect("green", Colour::green);
  expect("3", static_cast<Colour>(3));
  expect("1000", Colour::far);
}

TEST(StringFrom, ShowsWhatAnOptionalHolds) {
  expect("none", std::optional<int>());
  expect("4", std::optional(4));
  expect("red", std::optional(Colour::red));
}

TEST(StringFrom, ShowsTimesInNanoseconds) {
  expect("1500000 ns", std::chrono::microseconds(1500));
  expect("7 ns", std::chrono::steady_clock::time_point(std::chrono::nanoseconds(7)));
}

TEST(StringFrom, ShowsRangesAndPairs) {
  expect("{1, 2}", std::vector{1, 2});
  expect("{a, b}", std::set<std::string>{"b", "a"});
  expect("{(1, red)}", std::map<int, Colour>{{1, Colour::red}});
}

TEST(StringFrom, UsesATypesOwnOperator) {
  expect("x=3", Point{3});
  expect("{x=3}", std::vector{Point{3}});
}

TEST(StringFrom, SaysThatItHasNoText) { expect("(a value without a text)", Unprintable{}); }

TEST_GROUP(ErrorOf){};

TEST(ErrorOf, IsWhatIsSaidAgainstSomethingAndEmptyOtherwise) {
  CHECK_EQUAL("", error_of(Result<int>(3)));
  CHECK_EQUAL("a.toml:1: no", error_of(Result<int>(fail("a.toml:1: no"))));
}

TEST_GROUP(JsonLines) { TemporaryFolder folder; };

TEST(JsonLines, AreReadOneValueALine) {
  const auto values = parse_json_lines("{\"a\":1}\n\n{\"a\":2}");
  CHECK_EQUAL(2, values.size());
  CHECK_EQUAL(2, values[1]["a"].get<int>());
}

TEST(JsonLines, ThatAreBrokenAreNamed) {
  CHECK_THROWS(std::runtime_error, parse_json_lines("{\"a\":1}\n{\"a\":"));
}

TEST(JsonLines, OfAMissingFileAreNone) { CHECK(read_json_lines(folder / "none").empty()); }

TEST(JsonLines, TablesHaveNamedColumnsAndEmptyCells) {
  write_text(folder / "table.csv", "time_ns,line,name\n1,2,\n3,,KEY\n");
  const CsvTable table = read_csv(folder / "table.csv");
  CHECK_EQUAL(2, table.rows.size());
  CHECK_EQUAL("", table.rows[0].at(table.column("name")));
  CHECK_EQUAL("KEY", table.rows[1].at(table.column("name")));
  CHECK_THROWS(std::runtime_error, table.column("level"));
}

TEST_GROUP(Recorded){};

TEST(Recorded, LinesAreAlikeWithinATolerance) {
  CHECK_TRUE(alike("a 1.00 b", "a 1.01 b", 0.02));
  CHECK_FALSE(alike("a 1.00 b", "a 1.03 b", 0.02));
  CHECK_FALSE(alike("a 1.00 b", "a 1.00 c", 0.02));
  CHECK_FALSE(alike("a 1.00", "a 1.00 b", 0.02));
  CHECK_FALSE(alike("a 1.00", "a nan", 0.02));
  CHECK_TRUE(alike("a nan", "a nan", 0.02));
}

TEST(Recorded, ATextWithoutARecordDiffersFromItsFirstLineOn) {
  STRCMP_EQUAL("\n- \n+ # one", difference_from_record("no such record", "# one\ntwo\n", 0.0).c_str());
}

TEST_GROUP(HostBench){};

TEST(HostBench, ClockStandsUntilItIsMoved) {
  ManualClock clock;
  const auto before = clock.read();
  CHECK(clock.read().mono == before.mono);
  clock.now += milliseconds{5};
  CHECK(clock.read().mono == before.mono + milliseconds{5});
  CHECK(clock.read().wall == before.wall + milliseconds{5});
  clock.wall_ahead = milliseconds{7};
  CHECK(clock.read().mono == before.mono + milliseconds{5});
  CHECK(clock.read().wall == before.wall + milliseconds{12});
}

TEST(HostBench, BusBringsAPacketOnceAndRemembersWhatWasSentOnAChannel) {
  RememberingBus bus;
  bus.arriving = {{"bench/A", {1, 2}}, {"bench/B", {3}}};
  std::vector<std::string> heard;
  const auto hear = [&](const std::string& channel, auto) { heard.push_back(channel); };
  CHECK(bus.receive(milliseconds{1}, {}, hear));
  CHECK(bus.receive(milliseconds{1}, {}, hear));
  LONGS_EQUAL(2, heard.size());
  const std::vector<std::uint8_t> bytes{4, 5};
  bus.publish("bench/A", bytes);
  bus.publish("bench/B", bytes);
  CHECK(bus.sent_on("bench/A") == std::vector<std::vector<std::uint8_t>>{bytes});
  LONGS_EQUAL(2, bus.sent.size());
  bus.failed = true;
  CHECK(!bus.receive(milliseconds{1}, {}, hear));
}

TEST_GROUP(Traps){};

TEST(Traps, CatchWhatMakesANanOrAnInfinity) {
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return std::sqrt(x); }, -1.0));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return 1.0 / x; }, 0.0));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return x * x; }, 1e200));
  LONGS_EQUAL(SIGFPE, signal_of([](double x) { return x - x; }, std::numeric_limits<double>::infinity()));
}

TEST(Traps, LetUnderflowAndRoundingPass) {
  LONGS_EQUAL(0, signal_of([](double x) { return x * x; }, 1e-200));
  LONGS_EQUAL(0, signal_of([](double x) { return 1.0 / x; }, 3.0));
}

TEST(Traps, EndWithTheirScope) {
  { const FloatingPointTraps traps; }
  volatile double zero = 0.0;
  volatile double quotient = 1.0 / zero;
  CHECK(std::isinf(quotient));
}

TEST(Traps, FlagsTellWhetherACallRaisedAnException) {
  volatile double zero = 0.0, result = 0.0;
  CHECK(raises_exception([&] { result = 1.0 / zero; }));
  CHECK_FALSE(raises_exception([&] { result = 1.0 / 3.0; }));
}
