#include "common/config/nearest.hpp"

#include "tests/support/string_from.hpp"

namespace {

using strobe::config::nearest;

const std::vector<std::string> kNames{"--shots", "--session", "--spin", "--photographs", "--px-per-m"};

std::string nearest_of(const std::string& typed) { return nearest(typed, kNames).value_or("nothing"); }

}  // namespace

TEST_GROUP(Nearest){};

TEST(Nearest, FindsALetterLeftOutAddedChangedOrSwapped) {
  CHECK_EQUAL("--shots", nearest_of("--shot"));
  CHECK_EQUAL("--shots", nearest_of("--shotss"));
  CHECK_EQUAL("--shots", nearest_of("--shits"));
  CHECK_EQUAL("--spin", nearest_of("--sipn"));
}

TEST(Nearest, FindsWhatWasBegun) { CHECK_EQUAL("--photographs", nearest_of("--photo")); }

TEST(Nearest, ForgivesCapitalsAndDashes) {
  CHECK_EQUAL("--shots", nearest_of("-SHOTS"));
  CHECK_EQUAL("--px-per-m", nearest_of("--px-per-m=4000"));
}

TEST(Nearest, DoesNotGuessWhereNothingIsNear) {
  CHECK_EQUAL("nothing", nearest_of("--colour"));
  CHECK_EQUAL("nothing", nearest_of("--"));
  CHECK_EQUAL("nothing", nearest_of(""));
  CHECK_FALSE(nearest("a", {"b"}).has_value());
}

TEST(Nearest, AsksWhetherThatWasMeant) {
  CHECK_EQUAL("; did you mean --shots?", strobe::config::did_you_mean("--shot", kNames));
  CHECK_EQUAL("", strobe::config::did_you_mean("--colour", kNames));
}
