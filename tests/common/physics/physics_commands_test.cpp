// The commands contact and predict as a user runs them.
#include <chrono>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using strobe::testing::CompletedProcess;

namespace {

const std::string kZero23 = std::string(STROBE_THESIS_FOLDER) + "/contact/zero_23.csv";

const std::vector<std::string> kZero23Inputs{"--vx-td",
                                             "15.62",
                                             "--vy-td",
                                             "-6.701",
                                             "--e",
                                             "0.865",
                                             "--mu",
                                             "0.55",
                                             "--dwell-time-ms",
                                             "5.1996",
                                             "--dwell-distance-cm",
                                             "6.29"};

CompletedProcess run_strobe(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), STROBE_PROGRAM);
  return strobe::testing::run_process({.arguments = std::move(arguments), .environment = {}, .folder = {}},
                                      std::chrono::seconds(30));
}

CompletedProcess contact(const std::string& set, std::vector<std::string> more) {
  std::vector<std::string> arguments{"contact", set};
  arguments.insert(arguments.end(), kZero23Inputs.begin(), kZero23Inputs.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_strobe(arguments);
}

void check_one_complaint(const CompletedProcess& run, const std::string& expected) {
  LONGS_EQUAL(2, run.status->code);
  STRCMP_EQUAL("", run.out.c_str());
  STRCMP_EQUAL(expected.c_str(), run.err.c_str());
}

}  // namespace

TEST_GROUP(PhysicsCommands){};

TEST(PhysicsCommands, ContactPrintsOneJsonObjectWithItsInputs) {
  const CompletedProcess run = contact(kZero23, {"--form", "simplified", "--json"});
  LONGS_EQUAL(0, run.status->code);
  const auto lines = strobe::testing::parse_json_lines(run.out);
  LONGS_EQUAL(1, lines.size());
  const auto& json = lines[0];
  DOUBLES_EQUAL(1.13e-3, json["see_x_m"].get<double>(), 0.01e-3);
  DOUBLES_EQUAL(1.41e-3, json["see_y_m"].get<double>(), 0.01e-3);
  LONGS_EQUAL(19, json["n"].get<int>());
  DOUBLES_EQUAL(-0.0065, json["x_poly"][0].get<double>(), 0.00005);
  LONGS_EQUAL(4, json["rotation_poly"].size());
  CHECK(json["r2"]["rotation"].get<double>() > 0.9);
  STRCMP_EQUAL("simplified", json["inputs"]["form"].get<std::string>().c_str());
  DOUBLES_EQUAL(-6.701, json["inputs"]["vy_td_mps"].get<double>(), 0.0);
}

TEST(PhysicsCommands, ContactRefusesAFileWithLettersNamingLineAndColumn) {
  const strobe::testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "set.csv").string();
  strobe::testing::write_text(
      path, "time_fraction,x_fraction,y_fraction,rotation_fraction\n0,0,0,0\n0.5,abc,0,0\n");
  check_one_complaint(contact(path, {}), "strobe: " + path + ":3: x_fraction: 'abc' is not a number\n");
}

// Back -45 has eight images in print, one of which its correction leaves out.
TEST(PhysicsCommands, ContactTakesAProjectsSetWithItsMeansCorrectedOrAsPrinted) {
  const auto images = [](std::vector<std::string> arguments) {
    const CompletedProcess run = run_strobe(std::move(arguments));
    LONGS_EQUAL(0, run.status->code);
    const auto json = strobe::testing::parse_json_lines(run.out).at(0);
    DOUBLES_EQUAL(12.02, json["inputs"]["vx_td_mps"].get<double>(), 0.0);
    return json["n"].get<int>();
  };
  LONGS_EQUAL(7, images({"contact", "back_45", "--json"}));
  LONGS_EQUAL(8, images({"contact", "back_45", "--json", "--as-printed"}));
  check_one_complaint(run_strobe({"contact", "back_46"}),
                      "strobe: back_46: neither a file nor one of the project's sets (zero_17 to back_68)\n");
}

TEST(PhysicsCommands, ContactAsksForWhatAFileDoesNotBring) {
  check_one_complaint(run_strobe({"contact", kZero23}), "strobe: contact: --vx-td is needed with a file\n");
}

TEST(PhysicsCommands, ContactRefusesARestitutionAboveOne) {
  check_one_complaint(run_strobe({"contact", kZero23, "--vx-td", "15", "--vy-td", "-6", "--e", "1.2", "--mu",
                                  "0.5", "--dwell-time-ms", "5", "--dwell-distance-cm", "6"}),
                      "strobe: " + kZero23 + ": e must be from 0 to 1\n");
}

TEST(PhysicsCommands, PredictRollsOffAsTheThesisSays) {
  const CompletedProcess run =
      run_strobe({"predict", "--vx", "10", "--vy", "-12", "--model", "rigid", "--json"});
  LONGS_EQUAL(0, run.status->code);
  const auto json = strobe::testing::parse_json_lines(run.out).at(0);
  DOUBLES_EQUAL(6.0, json["vx_lo_mps"].get<double>(), 1e-12);
  STRCMP_EQUAL("grips", json["regime"].get<std::string>().c_str());
}

TEST(PhysicsCommands, PredictRefusesABallThatMovesAway) {
  check_one_complaint(run_strobe({"predict", "--vx", "10", "--vy", "12"}),
                      "strobe: predict: vy must be negative: the ball must move towards the surface\n");
}

TEST(PhysicsCommands, PredictOdeTellsTheContactsCourseEventsAndEnergy) {
  const CompletedProcess run =
      run_strobe({"predict", "--vx", "14.49", "--vy", "-9.95", "--model", "ode", "--e", "0.77",
                  "--dwell-time-ms", "4.84", "--samples", "11", "--json"});
  LONGS_EQUAL(0, run.status->code);
  const auto json = strobe::testing::parse_json_lines(run.out).at(0);
  STRCMP_EQUAL("grips", json["regime"].get<std::string>().c_str());
  DOUBLES_EQUAL(9.95 * 0.77, json["vy_lo_mps"].get<double>(), 1e-8);
  DOUBLES_EQUAL(4.84, json["dwell_time_ms"].get<double>(), 1e-8);
  STRCMP_EQUAL("release", json["events"].back()["event"].get<std::string>().c_str());
  LONGS_EQUAL(11, json["trajectory"].size());
  DOUBLES_EQUAL(json["vx_lo_mps"].get<double>(), json["trajectory"][10]["vx_mps"].get<double>(), 1e-12);
  double lost = 0.0;
  for (const char* loss : {"normal_damping_j", "normal_spring_left_j", "sliding_j", "tangential_damping_j",
                           "tangential_spring_left_j", "offset_j"})
    lost += json["energy"][loss].get<double>();
  DOUBLES_EQUAL(json["energy"]["kinetic_lost_j"].get<double>(), lost, 1e-8);
  DOUBLES_EQUAL(1e-9, json["inputs"]["tolerance"].get<double>(), 0.0);
}

TEST(PhysicsCommands, PredictOdeWritesTheCourseAsCsv) {
  const strobe::testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "contact.csv").string();
  const CompletedProcess run = run_strobe({"predict", "--vx", "10", "--vy", "-12", "--model", "ode",
                                           "--trajectory", path, "--samples", "5", "--json"});
  LONGS_EQUAL(0, run.status->code);
  LONGS_EQUAL(1, strobe::testing::parse_json_lines(run.out).size());
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  STRCMP_EQUAL("time_ms,x_m,y_m,angle_deg,vx_mps,vy_mps,omega_radps,fx_n,fy_n,mode", line.c_str());
  int rows = 0;
  while (std::getline(file, line)) ++rows;
  LONGS_EQUAL(5, rows);
  check_one_complaint(
      run_strobe({"predict", "--vx", "10", "--vy", "-12", "--model", "ode", "--trajectory",
                  (folder.path() / "none" / "contact.csv").string()}),
      "strobe: predict: " + (folder.path() / "none" / "contact.csv").string() + ": cannot be written\n");
}

TEST(PhysicsCommands, PredictNamesWhatIsWrongWithAContact) {
  check_one_complaint(run_strobe({"predict", "--vx", "10", "--vy", "-12", "--samples", "5"}),
                      "strobe: predict: --samples and --trajectory need --model ode\n");
  check_one_complaint(
      run_strobe({"predict", "--vx", "10", "--vy", "-12", "--model", "ode", "--kt-ratio", "0"}),
      "strobe: predict: e is below 0.001, or a spring or damping ratio is out of its range\n");
  check_one_complaint(
      run_strobe({"predict", "--vx", "10", "--vy", "-12", "--model", "ode", "--ode-tolerance", "2"}),
      "strobe: predict: tolerance or number of steps is out of its range\n");
}

TEST(PhysicsCommands, BothExplainThemselves) {
  for (const char* command : {"contact", "predict"}) {
    const CompletedProcess run = run_strobe({command, "--help"});
    LONGS_EQUAL(0, run.status->code);
    CHECK(run.out.find("Example") != std::string::npos);
  }
}
