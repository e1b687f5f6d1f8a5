#include "sim/scene/model_text.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

TEST_GROUP(ModelText){};

TEST(ModelText, ReadsWhatToHave) {
  CHECK(*parse_model("full") == Model::full());
  CHECK(*parse_model("none") == Model::none());
  CHECK(*parse_model("gravity,grip") == Model::none().with(Effect::gravity).with(Effect::grip));
}

TEST(ModelText, ReadsWhatToLeaveOut) {
  const Model expected = Model::full().without(Effect::pixels).without(Effect::drag);
  CHECK(*parse_model("-pixels,-drag") == expected);
  CHECK(*parse_model("-pixels,drag") == expected);
  CHECK(*parse_model("full-pixels-drag") == expected);
}

TEST(ModelText, NamesTheWordThatIsNoEffect) {
  for (const char* text : {"gravity,pixel", "-pixel", "", "full-", "gravity,,drag"})
    CHECK_TEXT(!parse_model(text).has_value(), text);
  STRCMP_CONTAINS("\"pixel\" is no effect; there are gravity, drag",
                  parse_model("gravity,pixel").error().message.c_str());
}

TEST(ModelText, WritesWhatItReads) {
  for (const char* text : {"full", "none", "gravity,grip", "-drag,-pixels"})
    STRCMP_EQUAL(text, model_text(*parse_model(text)).c_str());
}
