// What a person is told to do about a shot. The firmware's sources say for which reasons it aborts one.
#include "host/session/advice.hpp"

#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "common/config/files.hpp"
#include "tests/host/session_bench.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::advice;
using host::advice_on_abort;
using host::Shot;
using host_test::Bench;
using reduction::Flag;

std::string firmware_source(const std::string& file) {
  return config::read_file(std::string(STROBE_SOURCE_DIR "/firmware/") + file).value();
}

/// What the pattern's first group matches.
std::vector<std::string> found(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> words;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) words.push_back((*it)[1]);
  return words;
}

/// Every reason in words, as they stand in the sources.
std::vector<std::string> firmware_reasons() {
  std::vector<std::string> reasons;
  const auto add = [&](const std::string& file, const std::string& pattern, std::size_t least) {
    const auto words = found(firmware_source(file), pattern);
    CHECK_TEXT(words.size() >= least, (file + ": " + pattern).c_str());
    reasons.insert(reasons.end(), words.begin(), words.end());
  };
  add("core/shot_player.cpp", R"re(abort\("([^"]+)"\))re", 4);
  add("core/shot_player.cpp", R"re(return "([^"]+)";)re", 4);
  add("core/shot_player.cpp", R"re([?:] "([^"]+ could not be set)")re", 3);
  add("core/timed_outputs.cpp", R"re(failed\("([^"]+)")re", 1);
  add("flash_sequencer/outputs.cpp", R"re(give_up\(listener, "([^"]+)")re", 4);
  add("flash_sequencer/outputs.cpp", R"re(kWasReset = "([^"]+)")re", 1);
  // An arming that expires ends no shot.
  add("core/interlock.cpp", R"re(dispatch\(InterlockEvent::(?!expiry)\w+, "([^"]+)")re", 6);
  add("core/timed_outputs.hpp", R"re("(an output line [^"]+)")re", 1);
  add("core/sequencer.cpp", R"re(lines_fail\("([^"]+)"\))re", 2);
  add("worker/worker.cpp", R"re("(the guardian [^"]+|stopped by [^"]+|an output [^"]+)")re", 4);
  return reasons;
}

Shot aborted(const std::string& why) {
  Bench bench;
  bench.made.shot.aborted = true;
  bench.made.shot.abort_reason = why;
  bench.made.shot.trigger_ns = strobe_msgs::shot_t::NO_TIME;
  bench.shot();
  return bench.only_result();
}

}  // namespace

TEST_GROUP(Advice){};

TEST(Advice, IsGivenForEveryFlagThatAPersonCanDoSomethingAbout) {
  const std::map<Flag, std::string> nothing{
      {Flag::no_redundancy, "fewer images were there than a bad one is found with; sds are right"},
      {Flag::no_contact_image, "no number needs one"},
      {Flag::sd_from_residuals, "asked for, and the sds are right"},
      {Flag::flash_index_ambiguous, "no number depends on it"}};
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<Flag>(i);
    CHECK_EQUAL_TEXT(nothing.contains(flag), advice(flag).empty(), std::string(name(flag)).c_str());
  }
}

TEST(Advice, IsGivenForEveryReasonForWhichTheFirmwareAborts) {
  for (const std::string& reason : firmware_reasons())
    CHECK_TEXT(!advice_on_abort(reason).empty(), ("no advice on: " + reason).c_str());
  // Reasons with numbers in them: where they are put together, and what comes of it (tests/firmware).
  LONGS_EQUAL(3, found(firmware_source("core/shot_player.cpp"), R"re((abort\(why))re").size());
  for (const char* reason : {"flash 6 would have been 1712 us late", "trigger would have been 1712 us late",
                             "the flash sequencer refused a request out of turn",
                             "the flash sequencer cut the outputs: strobed's beats did not come",
                             "flash 21 would have come 2400 us after the one before", "the trigger was on for 120000 us"})
    CHECK_TEXT(!advice_on_abort(reason).empty(), reason);
  CHECK_TRUE(advice_on_abort("a reason of a later firmware").empty());
}

TEST(Advice, OfAnAbortIsAboutItsCauseAlone) {
  const std::map<std::string, std::string> causes{{"the e-stop is pressed", "e-stop"},
                                                  {"the key is off", "Turn the key on"},
                                                  {"key or e-stop cannot be read", "chip"},
                                                  {"disarmed by command", "Ctrl-C"},
                                                  {"the machine was suspended", "sleep"},
                                                  {"flash 3 would have been 1712 us late", "busy"},
                                                  {"the guardian died", "guardian"},
                                                  {"the interlock withheld the trigger", "faults"},
                                                  {"gate never seen", "light gate"},
                                                  {"a reason of a later firmware", "log"}};
  std::set<std::string> told;
  for (const auto& [reason, word] : causes) {
    const Shot shot = aborted(reason);
    CHECK_TRUE(shot.readout.flags.has(Flag::too_few_images));  // which aiming the camera does not mend
    STRCMP_CONTAINS(word.c_str(), advice(shot).c_str());
    CHECK_TEXT(advice(shot).find("aim the camera") == std::string::npos, reason.c_str());
    told.insert(advice(shot));
  }
  LONGS_EQUAL(causes.size(), told.size());
}

TEST(Advice, OfAShotWhoseEndIsNotKnownIsToLookAtWhatEnded) {
  const Shot shot = host::interrupted_shot({77, 6}, 5, false, "its end is in no log: the host, or strobed, ended during the shot");
  STRCMP_CONTAINS("power and logs", advice(shot).c_str());
}

TEST(Advice, TellsAPhotographWithoutTheBallFromOneWithTooFewImagesAndFromNone) {
  Bench empty, few, none;
  empty.made.frame.images.clear();
  few.made.frame.images.resize(1);
  for (Bench* bench : {&empty, &few}) {
    auto& frame = bench->made.frame;
    frame.image_count = static_cast<std::int32_t>(frame.images.size());
    bench->shot();
    bench->frame();
  }
  STRCMP_CONTAINS("whether the machine threw it", advice(empty.only_result()).c_str());
  const std::string of_few = advice(few.only_result());
  STRCMP_CONTAINS("aim the camera", of_few.c_str());
  none.shot();
  none.beat_until(none.end + 6 * host_test::kSecond);
  STRCMP_CONTAINS("strobe replay --complete", advice(none.only_result()).c_str());
}

TEST(Advice, IsGivenToAShotThatItsMatchRejectsWithoutAFlag) {
  Shot shot;
  CHECK_EQUAL("", advice(shot));
  shot.rejected = std::string(host::words(Flag::flash_match_ambiguous)) + " (e by 1.4 %)";
  CHECK_EQUAL(std::string(advice(Flag::flash_match_ambiguous)), advice(shot));
}

TEST(Advice, IsGivenOnceForEachThingToDo) {
  Shot shot;
  shot.readout.flags.set(Flag::overlaps_surface);
  shot.readout.flags.set(Flag::outlier_surface_point);
  CHECK_EQUAL("Look at the surface line: if it is wrong, give it by hand.", advice(shot));
}
