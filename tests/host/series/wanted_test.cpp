// What a person types that is to be known.
#include "host/series/wanted.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using reduction::Quantity;

TEST_GROUP(WantedNumbers){};

TEST(WantedNumbers, AreNamedAsShortAsIsPlainInUnitsOrPercent) {
  const auto wanted = parse_wanted("--want", {"e:0.003", "omega_lo:1%", "vx_td_mps:0.05"}, Percent::allowed).value();
  LONGS_EQUAL(3, wanted.size());
  CHECK_TRUE((wanted[0] == Wanted{Quantity::e, 0.003, false}));
  CHECK_TRUE((wanted[1] == Wanted{Quantity::omega_lo_radps, 1.0, true}));
  CHECK_TRUE((wanted[2] == Wanted{Quantity::vx_td_mps, 0.05, false}));
  DOUBLES_EQUAL(3.0, wanted[1].size(-300.0), 1e-12);
  DOUBLES_EQUAL(0.003, wanted[0].size(0.8), 0.0);
  CHECK_EQUAL(std::string("e:0.003,omega_lo_radps:1%,vx_td_mps:0.05"), wanted_text(wanted));
}

TEST(WantedNumbers, AreReadBackAsTheyAreWritten) {
  const auto wanted = parse_wanted("--want", {"mu:2.5%", "dwell_time:0.1"}, Percent::allowed).value();
  const std::string text = wanted_text(wanted);
  const std::size_t comma = text.find(',');
  const auto back =
      parse_wanted("--want", {text.substr(0, comma), text.substr(comma + 1)}, Percent::allowed).value();
  CHECK_TRUE(wanted == back);
}

TEST(WantedNumbers, AreRefusedWithTheOptionAndTheText) {
  const auto complaint = [](const std::vector<std::string>& texts, Percent percent) {
    return testing::error_of(parse_wanted("--want", texts, percent));
  };
  STRCMP_CONTAINS("--want 5: of which quantity?", complaint({"5"}, Percent::allowed).c_str());
  STRCMP_CONTAINS("--want vx:1: no \"vx\" among theta_in_deg", complaint({"vx:1"}, Percent::allowed).c_str());
  STRCMP_CONTAINS("--want e:1%: must be a number above 0", complaint({"e:1%"}, Percent::refused).c_str());
  for (const char* text : {"e:", "e:%", "e:0", "e:-1", "e:nan", "e:inf", "e:1e999", "e:1%%", "e:0.1 "})
    STRCMP_CONTAINS("must be a number above 0, or one with %", complaint({text}, Percent::allowed).c_str());
  STRCMP_CONTAINS("--want e:1%: this quantity is named twice", complaint({"e:1", "e:1%"}, Percent::allowed).c_str());
}
