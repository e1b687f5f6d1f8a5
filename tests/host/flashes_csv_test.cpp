#include "host/session/flashes_csv.hpp"

#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::FlashesCsv;
using strobe_msgs::flash_t;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

strobe_msgs::shot_t example(int shot_id) {
  strobe_msgs::shot_t shot{};
  shot.boot_id = 0x2a;
  shot.shot_id = shot_id;
  flash_t seen{};
  seen.lamps = 3;
  seen.commanded_ns = 1000, seen.issue_start_ns = 1010, seen.issue_end_ns = 1110;
  seen.observed_a_ns = 13'000, seen.observed_b_ns = 13'100;
  flash_t never{};
  never.flash_index = 1;
  never.lamps = 2;
  never.commanded_ns = 4000;
  never.issue_start_ns = never.issue_end_ns = never.observed_a_ns = never.observed_b_ns = flash_t::NO_TIME;
  never.extra_edges = 1;
  shot.flashes = {seen, never}, shot.flash_count = 2;
  return shot;
}

constexpr const char* kOfShotThree =
    "2a,3,0,ab,1000,1010,1110,13000,13100,0\n"
    "2a,3,1,b,4000,,,,,1\n";

}  // namespace

TEST_GROUP(FlashesTable) { TemporaryFolder folder; };

TEST(FlashesTable, HasEachFlashOnALineWithWhatWasNotThereEmpty) {
  auto csv = FlashesCsv::open(folder / "flashes.csv");
  CHECK(csv->add(example(3)).has_value());
  CHECK_EQUAL(host::flashes_header() + "\n" + kOfShotThree, read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, HasEachShotOnceOverSeveralRuns) {
  for (int run = 0; run < 2; ++run) {
    auto csv = FlashesCsv::open(folder / "flashes.csv");
    for (int again = 0; again < 2; ++again) CHECK(csv->add(example(3)).has_value());
  }
  CHECK_EQUAL(host::flashes_header() + "\n" + kOfShotThree, read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, TakesAShotWithoutFlashes) {
  auto csv = FlashesCsv::open(folder / "flashes.csv");
  auto shot = example(4);
  shot.flashes.clear(), shot.flash_count = 0;
  CHECK(csv->add(shot).has_value());
  CHECK_EQUAL(host::flashes_header() + "\n", read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, RefusesAnotherVersionsColumns) {
  write_text(folder / "flashes.csv", "shot,flash\n");
  STRCMP_CONTAINS("another version's columns",
                  FlashesCsv::open(folder / "flashes.csv").error().message.c_str());
}
