#include "sim/scene/model.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::sim;

TEST_GROUP(ModelText){};

TEST(ModelText, ReadsWhatToHave) {
  CHECK_EQUAL(Model::full(), *parse_model("full"));
  CHECK_EQUAL(Model::none(), *parse_model("none"));
  CHECK_EQUAL(Model::none().with(Effect::gravity).with(Effect::grip), *parse_model("gravity,grip"));
}

TEST(ModelText, ReadsWhatToLeaveOut) {
  const Model expected = Model::full().without(Effect::pixels).without(Effect::drag);
  CHECK_EQUAL(expected, *parse_model("-pixels,-drag"));
  CHECK_EQUAL(expected, *parse_model("-pixels,drag"));
  CHECK_EQUAL(expected, *parse_model("full-pixels-drag"));
}

TEST(ModelText, NamesTheWordThatIsNoEffect) {
  for (const char* text : {"gravity,pixel", "-pixel", "", "full-", "gravity,,drag"})
    CHECK_TEXT(!parse_model(text).has_value(), text);
  STRCMP_CONTAINS("\"pixel\" is no effect; there are gravity, drag",
                  parse_model("gravity,pixel").error().message.c_str());
}

TEST(ModelText, WritesWhatItReads) {
  for (const char* text : {"full", "none", "gravity,grip", "-drag,-pixels"})
    CHECK_EQUAL(text, model_text(*parse_model(text)));
}
