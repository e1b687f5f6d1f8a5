// strobe series, as shipped: what it makes of --difference and --over, before it reads any session.
#include "tests/support/program_run.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;

/// What it says of a folder that is not there with these words.
std::string told(std::vector<std::string> words) {
  words.insert(words.begin(), {STROBE_PROGRAM, "series", "nowhere"});
  const auto run = testing::run_program(std::move(words));
  LONGS_EQUAL(2, run.status->code);
  return run.err;
}

}  // namespace

TEST_GROUP(SeriesCommand){};

TEST(SeriesCommand, RefusesADifferenceWithoutItsQuantity) {
  STRCMP_CONTAINS("--difference 0.005: of which quantity?", told({"--difference", "0.005"}).c_str());
  STRCMP_CONTAINS("no \"vx\" among theta_in_deg", told({"--difference", "vx:1"}).c_str());  // touchdown or lift-off?
  STRCMP_CONTAINS("must be a number above 0", told({"--difference", "e:0.01,mu:-1"}).c_str());
  STRCMP_CONTAINS("must be a number above 0", told({"--difference", "e:0.01m"}).c_str());
  STRCMP_CONTAINS("must be a number above 0", told({"--difference", "e:"}).c_str());
}

TEST(SeriesCommand, RefusesAPowerThatNobodyCanMean) {
  for (const char* power : {"0.05", "1", "80"}) STRCMP_CONTAINS("--power", told({"--power", power}).c_str());
  STRCMP_CONTAINS("nowhere: no such folder", told({"--power", "0.9"}).c_str());
}

TEST(SeriesCommand, TakesADifferenceOfEachQuantityNamedAsShortAsItIsPlain) {
  for (const char* words : {"e:0.005", "omega_lo:5", "omega_lo_radps:5,e:0.005,dwell_time:0.1"})
    STRCMP_CONTAINS("nowhere: no such folder", told({"--difference", words}).c_str());
  STRCMP_CONTAINS("nowhere: no such folder", told({"--budget", "mu", "--difference", "0.01"}).c_str());
}

TEST(SeriesCommand, AndReportKnowWhatShotsMayDifferIn) {
  STRCMP_CONTAINS("no \"colour\" among spin", told({"--over", "colour"}).c_str());
  STRCMP_CONTAINS("nowhere: no such folder", told({"--over", "angle,operator"}).c_str());
  const auto run = testing::run_program({STROBE_PROGRAM, "report", "nowhere", "--over", "colour"});
  STRCMP_CONTAINS("no \"colour\" among spin", run.err.c_str());
}
