// Photographs from before a host's start, and shots of earlier runs that lack one.
#include "host/photographs/left_photographs.hpp"

#include <fmt/format.h>

#include <string>

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::LeftShots;
using host::OldFile;

constexpr HostTime kStart{std::chrono::seconds{1'800'000'000}};  // when the firmware's clock is at 0

}  // namespace

TEST_GROUP(LeftPhotographs) {
  testing::TemporaryFolder session;
  host::DeviceClock clock;
  LeftShots shots;
  std::vector<OldFile> files;

  void setup() override {
    clock.on_heartbeat(7, {}, kStart);
    std::filesystem::create_directory(session / "photographs");
  }
  enum class Has { result, photograph, nothing };
  void shot(int id, double closed_s, Has has, std::int64_t boot_id = 7) {
    strobe_msgs::shot_t shot{};
    shot.boot_id = boot_id;
    shot.shot_id = id;
    shot.shutter_open_ns = static_cast<std::int64_t>((closed_s - 0.5) * 1e9);
    shot.shutter_close_ns = static_cast<std::int64_t>(closed_s * 1e9);
    shots.exposures.push_back(shot);
    if (has == Has::nothing) shots.wanted.insert({boot_id, id});
    if (has == Has::photograph) shots.photographed.insert({boot_id, id});
  }
  void file(const std::string& name, double written_s) {
    files.push_back({"/camera/" + name, kStart + from_seconds(written_s)});
  }
  void keep(const std::string& name) { testing::write_text(session / "photographs" / name, ""); }
  /// "NAME>shot ", with * for a copy of the session's.
  std::string matched() {
    std::string text;
    for (const auto& left : host::match_left_photographs(shots, files, session.path(), clock, 5.0))
      text += fmt::format("{}>{}{} ", left.file.filename().string(), left.shot.shot_id, left.kept ? "*" : "");
    return text;
  }
};

TEST(LeftPhotographs, AFileWhoseTimeFitsIsTheShots) {
  shot(1, 10.0, Has::photograph);
  shot(2, 20.0, Has::nothing);
  file("a.tif", 10.4);
  file("b.tif", 20.4);
  CHECK_EQUAL("b.tif>2 ", matched());
}

TEST(LeftPhotographs, NoneIsTakenThatIsOlderThanTheShutterOrAMinuteLate) {
  shot(2, 20.0, Has::nothing);
  file("older.tif", 17.0);
  file("later.tif", 81.0);
  CHECK_EQUAL("", matched());
}

TEST(LeftPhotographs, OneThatAnotherShotHasIsNotTaken) {
  shot(1, 10.0, Has::photograph);
  shot(2, 20.0, Has::nothing);
  keep("shot-0001-late.tif");
  shots.names_used.insert("named.tif");
  file("late.tif", 20.2);
  file("named.tif", 20.3);
  CHECK_EQUAL("", matched());
}

TEST(LeftPhotographs, OneThatMayBeEithersIsNotTaken) {
  shot(1, 10.0, Has::result);
  shot(2, 20.0, Has::nothing);
  file("either.tif", 20.5);
  CHECK_EQUAL("", matched());
  file("first.tif", 10.5);
  CHECK_EQUAL("either.tif>2 ", matched());
}

TEST(LeftPhotographs, TheSessionsOwnCopyIsCertain) {
  shot(2, 20.0, Has::nothing);
  shot(3, 30.0, Has::nothing);
  keep("shot-0002-b.tif");
  file("b.tif", 20.4);
  file("c.tif", 30.4);
  CHECK_EQUAL("shot-0002-b.tif>2* c.tif>3 ", matched());
}

TEST(LeftPhotographs, ANumberThatTwoBootsHaveTellsNothing) {
  shot(2, 20.0, Has::nothing);
  shot(2, 40.0, Has::photograph, 8);
  keep("shot-0002-b.tif");
  CHECK_EQUAL("", matched());
}

TEST(LeftPhotographs, AnExposureInTwoFormatsIsOne) {
  shot(2, 20.0, Has::nothing);
  file("b.jpg", 20.4);
  file("b.tif", 20.5);
  CHECK_EQUAL("b.jpg>2 ", matched());
}

TEST(LeftPhotographs, OfABootThatNoLogHeardNoneIsTaken) {
  shot(2, 20.0, Has::nothing, 9);
  file("b.tif", 20.4);
  CHECK_EQUAL("", matched());
}
