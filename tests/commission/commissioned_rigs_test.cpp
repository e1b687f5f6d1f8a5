// A few rigs, sound ones and wrong ones, through camera and gravity: strobe-commission-study has them all.
#include <algorithm>
#include <string>

#include "tests/commission/wrong_rigs.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::commission_bench;

namespace {

std::string told(const Outcome& outcome) {
  std::string text = outcome.trouble + outcome.err;
  for (const auto& step : outcome.steps) text += step.dump() + "\n";
  return text;
}

void finds(const std::string& name, const std::vector<std::string>& steps) {
  const auto& all = wrong_rigs();
  const auto rig = std::ranges::find(all, name, &WrongRig::name);
  CHECK_TEXT(rig != all.end(), name.c_str());
  BenchOptions options = rig->options;
  options.only = steps;
  const Outcome outcome = commission(options);
  CHECK_TEXT(outcome.trouble.empty(), outcome.trouble.c_str());
  CHECK_TEXT(!found_by(*rig, outcome).empty(), told(outcome).c_str());
}

}  // namespace

TEST_GROUP(CommissionedRigs){};

TEST(CommissionedRigs, ASoundOnePassesByItsPictures) {
  BenchOptions options;
  options.only = {"light", "board", "gravity"};
  const Outcome outcome = commission(options);
  CHECK_TEXT(outcome.trouble.empty(), outcome.trouble.c_str());
  for (const char* id : {"light", "exposure_window", "board", "gravity", "inclination"}) {
    const auto* step = outcome.step(id);
    CHECK_TEXT(step != nullptr && step->at("state") == "passed", told(outcome).c_str());
  }
}

TEST(CommissionedRigs, ALampThatIsTurnedAwayIsNamed) { finds("lamp A turned away", {"light"}); }

TEST(CommissionedRigs, AScaleThatIsOnePercentOffIsFoundByFallingBalls) {
  finds("scale 1 % too large", {"gravity"});
}

TEST(CommissionedRigs, TheWrongRigsHaveNamesOfTheirOwn) {
  const auto& all = wrong_rigs();
  CHECK(all.size() >= 40);
  for (std::size_t i = 0; i < all.size(); ++i) {
    CHECK(!all[i].found_by.empty());
    for (std::size_t k = 0; k < i; ++k) CHECK(all[i].name != all[k].name);
  }
}
