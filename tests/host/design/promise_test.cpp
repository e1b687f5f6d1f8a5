#include "host/design/promise.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host;
using reduction::Quantity;

const char* const kPromise =
    R"({"quantities": {"e": {"expected": 0.8, "spread": 0.01, "shot_sd": 0.002, "shared_sd": 0.001}}})";

/// Of e in nine shots that scatter and are as uncertain as this.
std::vector<Kept> kept_with(double scatter_sd, double shot_sd) {
  SeriesSummary summary;
  QuantitySummary& e = summary.quantities[static_cast<std::size_t>(Quantity::e)];
  e.n = 9;
  e.scatter_sd = scatter_sd;
  e.expanded_uncertainty = 0.01;
  std::vector<Shot> shots(9);
  for (Shot& shot : shots) {
    shot.readout.value[Quantity::e] = 0.8;
    shot.readout.sd[Quantity::e] = shot_sd;
  }
  return kept(*parse_promise(kPromise, "design.json"), summary, shots);
}

}  // namespace

TEST_GROUP(Promise){};

TEST(Promise, IsReadFromWhatDesignPrinted) {
  const auto promise = parse_promise(kPromise, "design.json");
  CHECK_TRUE(promise.has_value());
  DOUBLES_EQUAL(0.002, (*promise)[static_cast<std::size_t>(Quantity::e)]->shot_sd, 0.0);
  CHECK_FALSE((*promise)[static_cast<std::size_t>(Quantity::mu)].has_value());
}

TEST(Promise, IsRefusedWithTheFilesNameWhereItIsNone) {
  for (const char* text : {"", "[1]", "{}", R"({"quantities": 1})", R"({"quantities": {"e": {"expected": 1}}})",
                           R"({"quantities": {"e": {"expected": 1, "spread": -1, "shot_sd": 1, "shared_sd": 0}}})",
                           R"({"quantities": {"e": {"expected": 1, "spread": 1, "shot_sd": 1, "shared_sd": 2}}})"}) {
    const auto promise = parse_promise(text, "some.json");
    CHECK_FALSE(promise.has_value());
    STRCMP_CONTAINS("some.json: ", promise.error().message.c_str());
  }
}

TEST(Promise, IsKeptByShotsThatScatterAsForetold) {
  const auto list = kept_with(0.0115, 0.0021);
  LONGS_EQUAL(1, list.size());
  CHECK_FALSE(list[0].scatter_missed);
  CHECK_FALSE(list[0].sd_missed);
  // 0.01, and 0.002 without the shared 0.001.
  DOUBLES_EQUAL(0.010149, list[0].promised_scatter, 1e-6);
}

TEST(Promise, IsMissedBeyondChance) {
  // Chi squared of 8 degrees of freedom exceeds 20.09 once in a hundred: 1.585 times the scatter.
  CHECK_FALSE(kept_with(1.55 * 0.010149, 0.002)[0].scatter_missed);
  CHECK_TRUE(kept_with(1.62 * 0.010149, 0.002)[0].scatter_missed);
  CHECK_TRUE(kept_with(0.01, 0.0026)[0].sd_missed);
}
