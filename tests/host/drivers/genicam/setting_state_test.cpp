#include "host/drivers/genicam/setting_state.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::genicam;
using tether::Setting;
using tether::SettingState;

TEST_GROUP(GenicamSettingState){};

TEST(GenicamSettingState, SameValueInOtherWordsIsAsAsked) {
  CHECK_TRUE(judged("Gain", Kind::number, "1", "3", "1.0", "").state == SettingState::as_asked);
  // A camera's float of 32 bits.
  CHECK_TRUE(judged("Gain", Kind::number, "0.1", "3", "0.10000000149011612", "").state ==
             SettingState::as_asked);
  CHECK_TRUE(judged("LUTEnable", Kind::boolean, "off", "true", "false", "").state == SettingState::as_asked);
  CHECK_TRUE(judged("LUTEnable", Kind::boolean, "0", "true", "false", "").state == SettingState::as_asked);
}

TEST(GenicamSettingState, AnotherNumberIsRoundedAndSaysByHowMuch) {
  const Setting setting = judged("ExposureTime", Kind::number, "50003", "10000", "50000", "");
  CHECK_TRUE(setting.state == SettingState::rounded);
  CHECK_EQUAL("by -3", setting.remark);
  CHECK_EQUAL("50000", setting.is);
  // Near by chance before.
  CHECK_TRUE(judged("ExposureTime", Kind::number, "50003", "50000", "50000", "").state ==
             SettingState::rounded);
}

TEST(GenicamSettingState, WhatTheCameraKeepsIsRefused) {
  const Setting silent = judged("Gain", Kind::number, "0", "6", "6", "");
  CHECK_TRUE(silent.state == SettingState::refused);
  CHECK_EQUAL("the camera said nothing", silent.remark);
  const Setting said =
      judged("ExposureMode", Kind::enumeration, "TriggerWidth", "Timed", "Timed", "not available");
  CHECK_TRUE(said.state == SettingState::refused);
  CHECK_EQUAL("not available", said.remark);
  CHECK_TRUE(judged("GammaEnable", Kind::boolean, "false", "true", "true", "").state ==
             SettingState::refused);
}
