// The command contact as a user runs it, beyond its stable fields.
#include <chrono>
#include <string>
#include <vector>

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"

#include <CppUTest/TestHarness.h>

using strobe::testing::CompletedProcess;

namespace {

const std::string kZero23 = std::string(STROBE_THESIS_FOLDER) + "/contact/zero_23.csv";

CompletedProcess contact(std::vector<std::string> more) {
  std::vector<std::string> arguments{STROBE_PROGRAM, "contact"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return strobe::testing::run_process({.arguments = std::move(arguments), .environment = {}, .folder = {}},
                                      std::chrono::seconds(30));
}

std::vector<std::string> file_with(std::vector<std::string> more) {
  std::vector<std::string> arguments{
      kZero23, "--vx-td", "15.62", "--vy-td",         "-6.701", "--e",
      "0.865", "--mu",    "0.55",  "--dwell-time-ms", "5.1996", "--dwell-distance-cm",
      "6.29",  "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

nlohmann::json json_of(const CompletedProcess& run) {
  LONGS_EQUAL(0, run.status->code);
  STRCMP_EQUAL("", run.err.c_str());
  return strobe::testing::parse_json_lines(run.out).at(0);
}

}  // namespace

TEST_GROUP(ContactCommand){};

TEST(ContactCommand, TellsGripForcesAndStiffnessOfAProjectsSetWithTheirSds) {
  const auto json = json_of(contact({"zero_17", "--json"}));
  STRCMP_EQUAL("zero_17", json["condition"].get<std::string>().c_str());
  CHECK(json["grip_fraction"].is_null());
  DOUBLES_EQUAL(15.7, json["stiffness_npm"]["half_period"].get<double>() / 1e3, 0.05);
  CHECK(json["sd"]["max_normal_force_n"].get<double>() > 0.0);
  CHECK(json["see_rotation_rad"].get<double>() < 0.05);
  CHECK(json["mechanics"]["see_x_m"].get<double>() < 2e-3);
  CHECK(json["leave_one_out"]["rotation_rad"]["spline"].is_number());
  CHECK(json["spline"]["see_y_m"].get<double>() < json["see_y_m"].get<double>());
}

TEST(ContactCommand, SaysNothingAboutSpinThatIsNotGiven) {
  const auto json = json_of(contact(file_with({})));
  CHECK(json["inputs"]["omega_td_radps"].is_null());
  CHECK(json["see_rotation_rad"].is_null());
  CHECK(json["sd"].is_null());
  CHECK(json["mechanics"].is_null());
  CHECK_FALSE(json.contains("grip_fraction"));
  CHECK(json["leave_one_out"]["rotation_rad"]["spline"].is_null());
}

TEST(ContactCommand, TakesSpinsInertiaAndTotalRotationAsGiven) {
  const auto json = json_of(contact(file_with(
      {"--omega-td", "2.61", "--omega-lo", "-313.2", "--alpha", "0.6", "--total-rotation-deg", "-51"})));
  DOUBLES_EQUAL(-51.0, json["total_rotation_deg"].get<double>(), 1e-12);
  STRCMP_EQUAL("given", json["total_rotation_source"].get<std::string>().c_str());
  CHECK(json["grip_fraction"].get<double>() > 0.5);
  CHECK(json["spline"]["see_rotation_rad"].is_number());
  DOUBLES_EQUAL(0.6, json["inputs"]["alpha"].get<double>(), 0.0);
}

TEST(ContactCommand, RefusesABallThatCannotBe) {
  const CompletedProcess run = contact(file_with({"--alpha", "0.8"}));
  LONGS_EQUAL(2, run.status->code);
  STRCMP_EQUAL("", run.out.c_str());
  CHECK(run.err.find("alpha") != std::string::npos);
}

TEST(ContactCommand, PrintsAPageForPeople) {
  const CompletedProcess run = contact({"top_23"});
  LONGS_EQUAL(0, run.status->code);
  for (const char* words :
       {"largest normal force", "stops skidding after", "Error of an image that was left out"})
    CHECK_TEXT(run.out.find(words) != std::string::npos, words);
}
