#include "common/messages/channels.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::messages;

TEST_GROUP(Channels){};

TEST(Channels, AreNamedAfterRigAndKind) {
  const Channel all[] = {Channel::command, Channel::event, Channel::status,
                         Channel::shot,    Channel::frame, Channel::readout};
  std::string names;
  for (const Channel channel : all) names += channel_name("b", channel) + " ";
  CHECK_EQUAL(
      "STROBE/b/COMMAND STROBE/b/EVENT STROBE/b/STATUS STROBE/b/SHOT STROBE/b/FRAME STROBE/b/READOUT ",
      names);
}

TEST(Channels, ARigsNameHas1To24LettersDigitsAndDashes) {
  for (const std::string& name : {std::string("azAZ09_-"), std::string(24, 'r')})
    CHECK_TRUE_TEXT(valid_rig_name(name), name.c_str());
  CHECK_FALSE(valid_rig_name("") || valid_rig_name(std::string(25, 'r')));
  for (const char c : {'`', '{', '@', '[', '/', ':', ' ', '.'})
    CHECK_FALSE(valid_rig_name(std::string("rig") + c));
}
