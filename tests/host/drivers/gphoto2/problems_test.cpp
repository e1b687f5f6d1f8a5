#include "host/drivers/gphoto2/problems.hpp"

#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::gphoto2;

constexpr std::int64_t kNow_s = 1'800'000'000;

}  // namespace

TEST_GROUP(Gphoto2Problems) {
  CameraState state{{}, 60'000'000'000, true, kNow_s};

  void set(const std::string& name, const std::string& value) { state.config[name].value = value; }
  /// All problems, those that prevent with a '!' before them.
  std::string found() const {
    std::string text;
    for (const auto& problem : find_problems(state)) text += (problem.prevents ? "!" : "") + problem.text + "\n";
    return text;
  }
  void check(const std::string& name, const std::string& bad, const std::string& good, const char* words) {
    set(name, good);
    CHECK_EQUAL("", found());
    set(name, bad);
    STRCMP_CONTAINS(words, found().c_str());
    state.config.erase(name);
  }
};

TEST(Gphoto2Problems, ASoundCameraHasNone) {
  for (const auto& [name, value] : {std::pair{"imageformat", "RAW"},
                                    {"iso", "800"},
                                    {"focusmode", "Manual"},
                                    {"autoexposuremode", "Bulb"},
                                    {"shutterspeed", "bulb"},
                                    {"batterylevel", "100%"},
                                    {"availableshots", "900"},
                                    {"autopoweroff", "0"},
                                    {"drivemode", "Single"},
                                    {"reviewtime", "None"}})
    set(name, value);
  CHECK_EQUAL("", found());
}

TEST(Gphoto2Problems, EachIsToldWithWhatMendsIt) {
  check("longexpnr", "On", "Off", "switch it off in its menu");
  check("imagequality", "JPEG Fine", "NEF (Raw)", "set its image quality or format to RAW");
  check("imagequality", "NEF+Fine", "NEF (Raw)", "a JPEG beside each RAW");
  check("imageformat", "RAW + Large Fine JPEG", "RAW", "a JPEG beside each RAW");
  check("iso", "Auto", "400", "set a number");
  check("isoauto", "On", "Off", "set a number");
  check("focusmode", "AF-S", "Manual", "set the lens to MF");
  check("focusmode", "One Shot", "Manual", "set the lens to MF");
  check("drivemode", "Continuous high speed", "Single", "set single pictures");
  check("autopoweroff", "60", "0", "goes to sleep after 60");
  check("reviewtime", "2 seconds", "None", "picture review is on");
  check("batterylevel", "12%", "80%", "its battery is at 12%");
  check("batterylevel", "Low", "100%", "its battery is at Low");
}

TEST(Gphoto2Problems, WhatMustNotBeFiredWithPrevents) {
  check("expprogram", "P", "M", "!its exposure mode is P: turn the dial to M or B");
  check("drivemode", "Self-timer 10 s", "Single", "!the self-timer is on");
  check("capturemode", "Mirror up", "Single Shot", "!mirror-up is a drive mode");
  check("shutterspeed", "1/60", "Bulb", "!its shutter speed is 1/60");
  check("availableshots", "0", "50", "!its card is full");
  state.free_bytes = 1'000'000;
  STRCMP_CONTAINS("!its card is full", found().c_str());
}

TEST(Gphoto2Problems, BulbIsWrongWhereExposuresAreTimed) {
  state.exposure_by_line = false;
  check("shutterspeed", "Bulb", "1/60", "!its shutter speed is bulb");
}

TEST(Gphoto2Problems, AClockInAnotherZoneIsNoneButAWrongOneIs) {
  check("datetime", std::to_string(kNow_s + 400), std::to_string(kNow_s + 5 * 3600 + 1800 + 30), "its clock is wrong");
  check("datetime", "1000", std::to_string(kNow_s), "its clock is wrong");
}
