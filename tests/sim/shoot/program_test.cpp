#include <fstream>
#include <sstream>
#include <string>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/reduce.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using strobe::testing::Process;

TEST_GROUP(ShootProgram) {
  strobe::testing::TemporaryFolder folder;
  std::string out, err;

  int shoot(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {STROBE_BUILD_DIR "/bin/strobe-sim", "shoot"});
    Process process({std::move(arguments), {}, {}}, folder.path());
    const auto status = process.wait(std::chrono::seconds(60));
    out = process.out();
    err = process.err();
    return status ? status->code : -2;
  }
};

TEST(ShootProgram, PrintsFramesThatReduceAndTheSameOnesAgain) {
  const std::string truth = (folder.path() / "truth.jsonl").string();
  LONGS_EQUAL(0, shoot({"--scene", "zero_23", "--shots", "4", "--seed", "9", "--truth", truth}));
  CHECK_EQUAL("", err);
  const std::string first = out;
  std::istringstream lines(first);
  int shots = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto frame = messages::frame_from_json(line);
    CHECK_TEXT(frame.has_value(), line.c_str());
    LONGS_EQUAL(++shots, frame->shot_id);
    const auto readout = reduction::reduce(*frame, reduction::Estimator::best);
    CHECK(readout && readout->value[reduction::Quantity::e].has_value());
  }
  LONGS_EQUAL(4, shots);
  std::ifstream file(truth);
  int truths = 0;
  for (std::string line; std::getline(file, line);)
    truths += line.find("\"readout\"") != std::string::npos ? 1 : 0;
  LONGS_EQUAL(4, truths);
  LONGS_EQUAL(0, shoot({"--scene", "zero_23", "--shots", "4", "--seed", "9", "--json"}));
  CHECK_EQUAL(first, out);
  LONGS_EQUAL(0, shoot({"--scene", "zero_23", "--shots", "4", "--seed", "10"}));
  CHECK(first != out);
}

TEST(ShootProgram, RefusesWhatItDoesNotKnowInOneLine) {
  const auto refused = [&](std::vector<std::string> arguments, const char* what) {
    LONGS_EQUAL(2, shoot(std::move(arguments)));
    CHECK_EQUAL("", out);
    STRCMP_CONTAINS(what, err.c_str());
    LONGS_EQUAL(err.size() - 1, err.find('\n'));
  };
  refused({"--scene", "no_such"}, "no_such");
  refused({"--scene", "zero_23", "--model=-pixel"}, "--model: \"pixel\" is no effect");
  refused({"--scene", "zero_23", "--shots", "0"}, "--shots");
  refused({"--scene", "zero_23", "--period-ms", "0.01"}, "--period-ms: must be");
  refused({"--scene", "zero_23", "--truth", "/no/such/folder/file"}, "cannot be written");
}

TEST(ShootProgram, SaysThatNotEverythingCouldBeWritten) {
  LONGS_EQUAL(1, shoot({"--scene", "zero_23", "--truth", "/dev/full"}));
  STRCMP_CONTAINS("/dev/full: not everything could be written", err.c_str());
}
