#include "host/drivers/gphoto2/settings.hpp"

#include <algorithm>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::gphoto2;
using strobe::tether::Setting;
using strobe::tether::SettingState;

Setting named(const std::vector<Setting>& settings, const std::string& name) {
  const auto found = std::ranges::find(settings, name, &Setting::name);
  return found == settings.end() ? Setting{} : *found;
}

}  // namespace

TEST_GROUP(Gphoto2Settings) {
  Config config{{"iso", {"800", {"100", "800"}, false}},
                {"f-number", {"f/5.6", {"f/5.6", "f/8"}, false}},
                {"shutterspeed", {"Bulb", {"1/1000", "0.0100s", "0.5", "Bulb"}, false}},
                {"longexpnr", {"On", {"On", "Off"}, false}},
                {"batterylevel", {"80%", {}, true}},
                {"lensname", {"50 mm", {}, true}}};
};

TEST(Gphoto2Settings, APersonsWordsFindTheCameras) {
  const std::vector<std::string> apertures{"f/5.6", "f/8"}, times{"1/1000", "Bulb", "0.0100s"};
  CHECK_EQUAL("f/5.6", choice_for("5.6", apertures));
  CHECK_EQUAL("f/8", choice_for("F/8", apertures));
  CHECK_EQUAL("Bulb", choice_for("bulb", times));
  CHECK_EQUAL("1/1000", choice_for("0.001", times));
  CHECK_EQUAL("0.0100s", choice_for("1/100", times));
  CHECK_EQUAL("0.3", choice_for("0.3", times));
}

TEST(Gphoto2Settings, WhatWasAskedForIsJudgedByWhatIsReadBack) {
  const std::map<std::string, std::string> wanted{{"iso", "640"},       {"f-number", "5.6"}, {"longexpnr", "Off"},
                                                  {"batterylevel", "1"}, {"none", "1"}};
  const auto settings = settings_of(config, wanted, {{"longexpnr", "Bad parameters"}, {"batterylevel", "no"}});
  CHECK(named(settings, "iso").state == SettingState::rounded);
  CHECK_EQUAL("800", named(settings, "iso").is);
  CHECK(named(settings, "f-number").state == SettingState::as_asked);
  CHECK(named(settings, "longexpnr").state == SettingState::refused);
  CHECK_EQUAL("Bad parameters; it has On, Off", named(settings, "longexpnr").remark);
  CHECK_EQUAL("it can be set on the camera only", named(settings, "batterylevel").remark);
  CHECK(named(settings, "none").state == SettingState::absent);
  CHECK(named(settings, "lensname").state == SettingState::read);
}

TEST(Gphoto2Settings, TheDriversOwnYieldToWhatIsAskedFor) {
  CHECK_EQUAL("Off", wanted_settings({}, config).at("longexpnr"));
  CHECK_EQUAL("On", wanted_settings({{"longexpnr", "On"}}, config).at("longexpnr"));
  CHECK(!wanted_settings({}, config).contains("capturetarget"));
}

TEST(Gphoto2Settings, ThePicturesTimeIsTheNearestByRatio) {
  const TimeChoice time = nearest_time(config, 0.02);
  CHECK_EQUAL("shutterspeed", time.name);
  CHECK_EQUAL("0.0100s", time.value);
  CHECK_EQUAL("0.5", nearest_time(config, 10.0).value);
  CHECK_EQUAL("", nearest_time({}, 1.0).name);
}
