#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace {

enum class Colour { red, green = 5, far = 1000 };

struct Point {
  int x = 0;
  friend std::ostream& operator<<(std::ostream& stream, const Point& point) {
    return stream << "x=" << point.x;
  }
};
struct Unprintable {};

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
