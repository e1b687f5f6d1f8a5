#include <algorithm>

#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::testing;

namespace {

const std::string kZero23 = std::string(STROBE_THESIS_FOLDER) + "/contact/zero_23.csv";

CompletedProcess contact(std::vector<std::string> more) {
  more.insert(more.begin(), {STROBE_PROGRAM, "contact"});
  return run_program(std::move(more));
}

/// Of a file, with what it does not bring but the spin.
CompletedProcess contact_of(const std::string& set, const std::vector<std::string>& more) {
  std::vector<std::string> words{
      set,     "--vx-td", "15.62", "--vy-td",         "-6.701", "--e",
      "0.865", "--mu",    "0.55",  "--dwell-time-ms", "5.1996", "--dwell-distance-cm",
      "6.29"};
  words.insert(words.end(), more.begin(), more.end());
  return contact(std::move(words));
}

CompletedProcess predict(const char* vx, const char* vy, std::vector<std::string> more) {
  more.insert(more.begin(), {STROBE_PROGRAM, "predict", "--vx", vx, "--vy", vy});
  return run_program(std::move(more));
}

CompletedProcess reduce(std::vector<std::string> more) {
  more.insert(more.begin(), {STROBE_PROGRAM, "reduce",
                             STROBE_SOURCE_DIR "/tests/fuzz/corpus/reduction_frame_json/every_key.json"});
  return run_program(std::move(more));
}

}  // namespace

TEST_GROUP(PhysicsCommands) { TemporaryFolder folder; };

TEST(PhysicsCommands, ContactPrintsOneJsonObjectWithItsInputs) {
  const auto json = json_of(contact_of(kZero23, {"--form", "simplified", "--json"}));
  DOUBLES_EQUAL(1.13e-3, json["see_x_m"].get<double>(), 0.01e-3);
  DOUBLES_EQUAL(1.41e-3, json["see_y_m"].get<double>(), 0.01e-3);
  CHECK_EQUAL(19, json["n"]);
  DOUBLES_EQUAL(-0.0065, json["x_poly"][0].get<double>(), 0.00005);
  LONGS_EQUAL(4, json["rotation_poly"].size());
  CHECK(json["r2"]["rotation"] > 0.9);
  CHECK_EQUAL("simplified", json["inputs"]["form"]);
  CHECK_EQUAL(-6.701, json["inputs"]["vy_td_mps"]);
}

TEST(PhysicsCommands, ContactRefusesAFileWithLettersNamingLineAndColumn) {
  const std::string path = folder / "set.csv";
  write_text(path, "time_fraction,x_fraction,y_fraction,rotation_fraction\n0,0,0,0\n0.5,abc,0,0\n");
  check_refused(contact_of(path, {}), path + ":3: x_fraction: 'abc' is not a number");
}

TEST(PhysicsCommands, ContactCountsAnImageOnceHoweverOftenItStandsInTheFile) {
  const std::string path = folder / "set.csv";
  const std::string header = "time_fraction,x_fraction,y_fraction,rotation_fraction\n", row = "0.1,0.1,-0.03,0.1\n";
  write_text(path, header + row + row + row + row + row);
  check_refused(contact_of(path, {"--omega-td", "0", "--omega-lo", "-300"}),
                path + ": at least two rows are needed between touchdown and lift-off "
                       "(4 rows repeat others and do not count)");
  const std::string others = "0.3,0.32,-0.1,0.2\n0.5,0.54,-0.15,0.5\n0.8,0.82,-0.08,0.9\n0.9,0.91,-0.05,0.88\n";
  const std::vector<std::string> spun{"--omega-td", "0", "--omega-lo", "-300", "--json"};
  write_text(path, header + row + others);
  auto once = json_of(contact_of(path, spun));
  write_text(path, header + others + row + row + row);  // in another order sums would differ by rounding
  check_prints(contact_of(path, {}),
               {": 5 images between touchdown and lift-off (2 rows repeat others and do not count)"});
  write_text(path, header + row + row + others + row);
  auto thrice = json_of(contact_of(path, spun));
  CHECK_EQUAL(0, once["inputs"]["repeated"]);
  CHECK_EQUAL(2, thrice["inputs"]["repeated"]);
  once["inputs"].erase("repeated");
  thrice["inputs"].erase("repeated");
  CHECK_EQUAL(once, thrice);
}

TEST(PhysicsCommands, ContactRefusesAnImageOfTheBallInTheAir) {
  const std::string path = folder / "set.csv";
  write_text(path, "time_fraction,x_fraction,y_fraction,rotation_fraction\n"
                   "0.1,0.1,-0.3,0.1\n0.5,0.5,-0.2,0.5\n1.5,2,-3,4\n");
  check_refused(contact_of(path, {}),
                path + ":4: time_fraction: must be from -0.05 to 1.05: 0 is touchdown, 1 lift-off");
}

// A cubic through four images meets them; a spline needs images at three times.
TEST(PhysicsCommands, ContactGivesNoSdWhereNothingTellsIt) {
  const std::string path = folder / "set.csv";
  const std::string header = "time_fraction,x_fraction,y_fraction,rotation_fraction\n";
  const std::vector<std::string> spun{"--omega-td", "0", "--omega-lo", "-300", "--json"};
  write_text(path, header + "0.1,0.1,-0.03,0.1\n0.3,0.32,-0.1,0.2\n0.5,0.54,-0.15,0.5\n0.8,0.82,-0.08,0.9\n");
  const auto four = json_of(contact_of(path, spun));
  CHECK(four["x_poly"].is_array());
  CHECK(four["poly_se"]["x"].is_null());
  for (const auto& [name, sd] : four["cubic"]["sd"].items()) CHECK_TEXT(sd.is_null(), name.c_str());
  CHECK(four["total_rotation_sd_deg"] > 0.0);
  STRCMP_CONTAINS(" +- -  ", contact_of(path, {}).out.c_str());
  write_text(path, header + "0.4,0.4,-0.1,0.3\n0.4,0.42,-0.12,0.32\n0.4,0.41,-0.11,0.31\n0.4,0.4,-0.11,0.33\n");
  const auto at_once = json_of(contact_of(path, spun));
  CHECK(at_once["x_poly"].is_null());
  CHECK(at_once["spline"]["see_x_m"].is_null());
  CHECK_FALSE(at_once["spline"].contains("max_normal_force_n"));
  CHECK(at_once["total_rotation_sd_deg"] > 0.0);  // by how they scatter
}

// Back -45 has eight images in print, one of which its correction leaves out.
TEST(PhysicsCommands, ContactTakesAProjectsSetWithItsMeansCorrectedOrAsPrinted) {
  const auto corrected = json_of(contact({"back_45", "--json"}));
  const auto printed = json_of(contact({"back_45", "--json", "--as-printed"}));
  CHECK_EQUAL(7, corrected["n"]);
  CHECK_EQUAL(8, printed["n"]);
  for (const auto& json : {corrected, printed}) CHECK_EQUAL(12.02, json["inputs"]["vx_td_mps"]);
  check_refused(contact({"back_46"}),
                "back_46: neither a file nor one of the project's sets (zero_17 to back_68)");
}

TEST(PhysicsCommands, ContactAsksForWhatAFileDoesNotBringAndRefusesWhatCannotBe) {
  check_refused(contact({kZero23}), "contact: --vx-td is needed with a file");
  check_refused(contact({kZero23, "--vx-td", "15", "--vy-td", "-6", "--e", "1.2", "--mu", "0.5",
                         "--dwell-time-ms", "5", "--dwell-distance-cm", "6"}),
                kZero23 + ": e must be from 0 to 1");
  const auto too_heavy = contact_of(kZero23, {"--alpha", "0.8"});
  LONGS_EQUAL(2, too_heavy.status->code);
  CHECK_EQUAL("", too_heavy.out);
  STRCMP_CONTAINS("alpha", too_heavy.err.c_str());
}

TEST(PhysicsCommands, ContactTellsGripForcesAndStiffnessOfAProjectsSetWithTheirSds) {
  const auto json = json_of(contact({"zero_17", "--json"}));
  CHECK_EQUAL("zero_17", json["condition"]);
  CHECK(json["grip_fraction"].is_null());
  DOUBLES_EQUAL(15.7, json["stiffness_npm"]["half_period"].get<double>() / 1e3, 0.05);
  CHECK(json["sd"]["max_normal_force_n"] > 0.0);
  CHECK(json["see_rotation_rad"] < 0.05);
  CHECK(json["mechanics"]["see_x_m"] < 2e-3);
  CHECK(json["leave_one_out"]["rotation_rad"]["spline"].is_number());
  CHECK(json["spline"]["see_y_m"] < json["see_y_m"]);
}

TEST(PhysicsCommands, ContactSaysNothingAboutSpinThatIsNotGiven) {
  const auto json = json_of(contact_of(kZero23, {"--json"}));
  for (const char* path : {"/inputs/omega_td_radps", "/see_rotation_rad", "/sd", "/mechanics",
                           "/leave_one_out/rotation_rad/spline"})
    CHECK_TEXT(json.at(nlohmann::json::json_pointer(path)).is_null(), path);
  CHECK_FALSE(json.contains("grip_fraction"));
}

TEST(PhysicsCommands, ContactTakesSpinsInertiaAndTotalRotationAsGiven) {
  const auto json = json_of(contact_of(kZero23, {"--json", "--omega-td", "2.61", "--omega-lo", "-313.2",
                                                 "--alpha", "0.6", "--total-rotation-deg", "-51"}));
  DOUBLES_EQUAL(-51.0, json["total_rotation_deg"].get<double>(), 1e-12);
  CHECK_EQUAL("given", json["total_rotation_source"]);
  CHECK(json["grip_fraction"] > 0.5);
  CHECK(json["spline"]["see_rotation_rad"].is_number());
  CHECK_EQUAL(0.6, json["inputs"]["alpha"]);
}

TEST(PhysicsCommands, ContactPrintsAPageForPeople) {
  check_prints(contact({"top_23"}),
               {"largest normal force", "stops skidding after", "Error of an image that was left out"});
}

TEST(PhysicsCommands, PredictRollsOffAsTheThesisSays) {
  const auto json = json_of(predict("10", "-12", {"--model", "rigid", "--json"}));
  DOUBLES_EQUAL(6.0, json["vx_lo_mps"].get<double>(), 1e-12);
  CHECK_EQUAL("grips", json["regime"]);
}

TEST(PhysicsCommands, PredictOdeTellsTheContactsCourseEventsAndEnergy) {
  const auto json = json_of(
      predict("14.49", "-9.95",
              {"--model", "ode", "--e", "0.77", "--dwell-time-ms", "4.84", "--samples", "11", "--json"}));
  CHECK_EQUAL("grips", json["regime"]);
  DOUBLES_EQUAL(9.95 * 0.77, json["vy_lo_mps"].get<double>(), 1e-8);
  DOUBLES_EQUAL(4.84, json["dwell_time_ms"].get<double>(), 1e-8);
  CHECK_EQUAL("release", json["events"].back()["event"]);
  LONGS_EQUAL(11, json["trajectory"].size());
  DOUBLES_EQUAL(json["vx_lo_mps"].get<double>(), json["trajectory"][10]["vx_mps"].get<double>(), 1e-12);
  double lost = 0.0;
  for (const char* loss : {"normal_damping_j", "normal_spring_left_j", "sliding_j", "tangential_damping_j",
                           "tangential_spring_left_j", "offset_j"})
    lost += json["energy"][loss].get<double>();
  DOUBLES_EQUAL(json["energy"]["kinetic_lost_j"].get<double>(), lost, 1e-8);
  CHECK_EQUAL(1e-9, json["inputs"]["tolerance"]);
}

// Friction acts along the slip: of a ball that spins about x only, across and along its way in the ratio of the slip.
TEST(PhysicsCommands, PredictTellsTheBounceOutOfThePlane) {
  for (const char* model : {"rigid", "grip", "ode"}) {
    const auto json = json_of(predict("20", "-5", {"--vz", "1", "--omega-x", "-100", "--mu", "0.2", "--model", model, "--json"}));
    DOUBLES_EQUAL((1.0 + 0.5 * 0.0651 * 100.0) / 20.0, std::tan(json["slip_direction_td_deg"].get<double>() * M_PI / 180.0), 1e-12);
    CHECK_EQUAL("slides", json["regime"]);
    CHECK(json["vz_lo_mps"].get<double>() < 0.9 && json["omega_x_lo_radps"].get<double>() > -99.0);
    CHECK_EQUAL(1.0, json["inputs"]["vz_mps"]);
  }
  check_prints(predict("10", "-12", {"--omega-x", "50"}), {"vz m/s", "degrees from x towards z"});
  check_refused(predict("10", "-12", {"--vz", "1", "--model", "pulse"}),
                "predict: --vz is for --model rigid, grip or ode, not pulse");
  check_refused(predict("10", "-12", {"--vz", "1", "--model", "ode", "--samples", "5"}),
                "predict: --samples is for motion in the plane");
}

TEST(PhysicsCommands, PredictOdeWritesTheCourseAsCsvBelowItsTable) {
  const CompletedProcess run = predict("10", "-12", {"--model", "ode", "--samples", "5"});
  const auto begin = run.out.find("time_ms,x_m,y_m,angle_deg,vx_mps,vy_mps,omega_radps,fx_n,fy_n,mode\n0,");
  CHECK(begin != std::string::npos);
  LONGS_EQUAL(1 + 5, std::count(run.out.begin() + static_cast<std::ptrdiff_t>(begin), run.out.end(), '\n'));
}

TEST(PhysicsCommands, PredictNamesWhatIsWrongWithAContact) {
  check_refused(predict("10", "12", {}),
                "predict: vy must be negative: the ball must move towards the surface");
  check_refused(predict("10", "-12", {"--model", "ode", "--ct", "11"}),
                "predict: e is below 0.001, kt over k not from 0.001 to 1000, or ct neither 0 nor from 0.01 to 10");
  check_refused(predict("10", "-12", {"--model", "ode", "--ode-tolerance", "2"}),
                "predict: tolerance is out of its range");
}

TEST(PhysicsCommands, PredictRefusesOptionsOfAnotherModel) {
  check_refused(predict("10", "-12", {"--samples", "5"}), "predict: --samples is for --model ode, not grip");
  check_refused(predict("10", "-12", {"--model", "rigid", "--ex", "0.1"}),
                "predict: --ex is for --model grip, not rigid");
  check_refused(predict("10", "-12", {"--mass-kg", "0.06"}),
                "predict: --mass-kg is for --model pulse or ode, not grip");
  LONGS_EQUAL(0, predict("10", "-12", {"--model", "pulse", "--mass-kg", "0.06"}).status->code);
}

TEST(PhysicsCommands, ReduceTakesStatedSdsForRelativeWeightsWhereNoiseComesFromResiduals) {
  const auto believed = json_of(reduce({"--json"}));
  const auto weights = json_of(reduce({"--noise", "residuals", "--json"}));
  CHECK_TRUE(believed["residual_ratio"].is_number());
  CHECK_TRUE(weights["residual_ratio"].is_null());
  CHECK_TRUE(believed["degrees_of_freedom"]["e"].is_null());
  CHECK_TRUE(weights["degrees_of_freedom"]["e"].is_number());
  check_refused(reduce({"--noise", "residuals", "--estimator", "two-point"}),
                "reduce: --noise residuals needs --estimator best");
  check_prints(reduce({}), {"residuals over stated noise: "});
}

TEST(PhysicsCommands, ExplainThemselves) {
  for (const char* command : {"contact", "predict", "reduce"})
    check_prints(run_program({STROBE_PROGRAM, command, "--help"}), {"Example"});
}
