#include "host/config/digitize_times.hpp"
#include "host/config/plan_file.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::host;

namespace {

std::string complaint(const std::string& text) {
  return strobe::testing::error_of(parse_flash_times(text, "t.json"));
}

}  // namespace

TEST_GROUP(DigitizeTimes){};

TEST(DigitizeTimes, AreArraysOrObjectsOneALine) {
  const auto times =
      parse_flash_times("[0, 0.003]\n\n{\"shot\": 2, \"flash_times_s\": [1, 1.5, 2]}\n", "t.json").value();
  LONGS_EQUAL(2, times.size());
  DOUBLES_EQUAL(0.003, times[0].at(1), 0.0);
  LONGS_EQUAL(3, times[1].size());
}

TEST(DigitizeTimes, OfACodedPlanAreThoseOfItsFlashes) {
  const auto plan =
      read_plan("intervals_us = [3000, 3400]\nshutter_open_ms = 10\nomit = [1]\n", "p.toml", {});
  const auto times = plan_flashes(plan->shot());
  LONGS_EQUAL(3, times.size());
  DOUBLES_EQUAL(0.0, times[0], 0.0);
  DOUBLES_EQUAL(0.0064, times[1], 1e-12);
  DOUBLES_EQUAL(0.0094, times[2], 1e-12);
}

TEST(DigitizeTimes, LeaveOutFlashesThatNoSensorSaw) {
  const auto times = parse_flash_times("[null, 0.003, null, 0.009]", "t.json").value();
  LONGS_EQUAL(2, times[0].size());
  DOUBLES_EQUAL(0.009, times[0].at(1), 0.0);
  CHECK_EQUAL("t.json:1: no flash was seen", complaint("[null]"));
}

TEST(DigitizeTimes, ThatAreWrongAreNamedByFileAndLine) {
  CHECK_EQUAL("t.json: no flashes", complaint("\n"));
  CHECK_EQUAL("t.json:2: is not JSON", complaint("[0]\n[1,\n"));
  CHECK_EQUAL("t.json:1: no flash_times_s", complaint("{\"times\": [0]}"));
  CHECK_EQUAL("t.json:1: must be an array of seconds, or an object with flash_times_s", complaint("3"));
  CHECK_EQUAL("t.json:1: must be 1 to 100000 flashes", complaint("[]"));
  CHECK_EQUAL("t.json:1: flash 1 is not a number", complaint("[0, \"1\"]"));
  CHECK_EQUAL("t.json:1: flash 2 is not after the one before", complaint("[0, 1, 1]"));
  CHECK_EQUAL("t.json:1: flash 0 is beyond 1e9 s", complaint("[1e10]"));
}

TEST(DigitizeTimes, OfAnEvenTrainCountFromTheFirstImage) {
  strobe::reduction::Frame frame;
  for (const int flash : {70, 71, 73}) {
    strobe::reduction::BallImage image;
    image.flash_index = flash;
    image.time_s = even_flashes(0.003).at(static_cast<std::size_t>(flash));
    frame.images.push_back(image);
  }
  count_from_first_image(frame);
  LONGS_EQUAL(0, frame.images[0].flash_index.value());
  LONGS_EQUAL(3, frame.images[2].flash_index.value());
  DOUBLES_EQUAL(0.0, frame.images[0].time_s, 0.0);
  DOUBLES_EQUAL(0.009, frame.images[2].time_s, 1e-15);  // rounding of 0.219
}
