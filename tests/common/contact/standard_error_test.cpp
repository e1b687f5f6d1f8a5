#include <cmath>
#include <numbers>

#include "common/contact/standard_error.hpp"
#include "tests/common/physics/thesis_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using contact::ContactInputs;
using impact::PulseForm;
using strobe::testing::thesis_data;
using thesis::Version;

namespace {

// Table 15's unrounded e, dwell time and |vy|; the rest from Tables 5–9.
const ContactInputs kZero{15.62, -6.701, 0.8650, 0.55, 5.1996e-3, 0.0629, 0.0651, PulseForm::simplified};
const ContactInputs kTop{16.19, -6.753, 0.9059, 0.45, 5.0704e-3, 0.0653, 0.0651, PulseForm::simplified};
const ContactInputs kBack{15.95, -6.589, 0.8010, 0.52, 5.1241e-3, 0.0648, 0.0651, PulseForm::simplified};

void check_see(const char* name, const ContactInputs& inputs, double x_mm, double y_mm, int n) {
  const auto see = contact::pulse_standard_errors(thesis_data(Version::as_printed).contact.at(name), inputs);
  CHECK(see.has_value());
  // Two decimals are known of these figures, found with inputs rounded like the ones above.
  DOUBLES_EQUAL(x_mm, 1e3 * see->see_x_m, 0.01);
  DOUBLES_EQUAL(y_mm, 1e3 * see->see_y_m, 0.01);
  LONGS_EQUAL(n, see->n);
}

data::ContactSet set_on_pulse(const ContactInputs& in, double error_m) {
  const auto pulse = impact::SinePulse::make(in.form, {.vx_td_mps = in.vx_td_mps,
                                                       .vy_td_mps = in.vy_td_mps,
                                                       .e = in.e,
                                                       .impulse_ratio = in.mu,
                                                       .dwell_s = in.dwell_time_s});
  data::ContactSet set{.name = "made", .rows = {{0, 0, 0, 0}}};
  double sign = 1.0;
  for (const double t : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    const auto state = pulse->at_fraction(t);
    set.rows.push_back({t, (state.x_m + sign * error_m) / in.dwell_distance_m,
                        (state.y_m - sign * 2.0 * error_m) / in.diameter_m, t});
    sign = -sign;
  }
  set.rows.push_back({1, 1, 0, 1});
  return set;
}

}  // namespace

TEST_GROUP(StandardErrorOfEstimate){};

TEST(StandardErrorOfEstimate, OfTheSimplifiedPulseIsWhatThePrintedRowsGive) {
  check_see("zero_23", kZero, 1.13, 1.41, 19);
  check_see("top_23", kTop, 0.98, 1.69, 10);
  check_see("back_22", kBack, 0.96, 1.80, 12);
}

// Table 17 prints these; the vertical ones come within a tenth, the horizontal ones need not (back: 0.533).
TEST(StandardErrorOfEstimate, VerticallyComesNearThePrintedTable17) {
  const auto& sets = thesis_data(Version::as_printed).contact;
  const auto vertical_mm = [&sets](const char* name, const ContactInputs& in) {
    return 1e3 * contact::pulse_standard_errors(sets.at(name), in)->see_y_m;
  };
  DOUBLES_EQUAL(1.661, vertical_mm("top_23", kTop), 0.1 * 1.661);
  DOUBLES_EQUAL(1.688, vertical_mm("back_22", kBack), 0.1 * 1.688);
}

TEST(StandardErrorOfEstimate, IsHadForAllSetsInBothFormsAndBothVersions) {
  for (const Version version : {Version::as_printed, Version::corrected}) {
    const thesis::Data& data = thesis_data(version);
    for (const auto& c : data.conditions) {
      for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
        const ContactInputs in{c.vx_td_mps.mean,
                               c.vy_td_mps.mean,
                               c.e.mean,
                               c.mu.mean,
                               c.dwell_time_ms.mean / 1e3,
                               c.dwell_distance_cm.mean / 1e2,
                               0.0651,
                               form};
        const auto see = contact::pulse_standard_errors(data.contact.at(c.name()), in);
        CHECK_TEXT(see.has_value(), c.name().c_str());
        // The measured top goes down 1.27 times the pulse's depth, and a half-wave's rms is .7 of its height:
        // .19 of the depth is expected; half of the depth would be no model. Back -17 is printed with its
        // drop upwards.
        const bool upwards = version == Version::as_printed && c.name() == "back_17";
        const double depth_m = -in.vy_td_mps * in.dwell_time_s / std::numbers::pi;
        CHECK_TEXT(upwards == (see->see_y_m > 0.5 * depth_m), c.name().c_str());
      }
    }
  }
}

TEST(StandardErrorOfEstimate, OfRowsOnThePulseIsZeroAndOfErrorsTheirRootMeanSquare) {
  ContactInputs in = kZero;
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    in.form = form;
    const auto none = contact::pulse_standard_errors(set_on_pulse(in, 0.0), in);
    DOUBLES_EQUAL(0.0, none->see_x_m, 1e-16);
    DOUBLES_EQUAL(0.0, none->see_y_m, 1e-16);
    // Five errors of ±1 mm: sqrt(5/4) mm.
    const auto see = contact::pulse_standard_errors(set_on_pulse(in, 1e-3), in);
    DOUBLES_EQUAL(std::sqrt(1.25) * 1e-3, see->see_x_m, 1e-15);
    DOUBLES_EQUAL(std::sqrt(1.25) * 2e-3, see->see_y_m, 1e-15);
  }
}

TEST(StandardErrorOfEstimate, RefusesInputsOutOfRangeAndSetsTooShort) {
  const auto set = set_on_pulse(kZero, 0.0);
  const auto complaint = [&set](auto change) {
    ContactInputs in = kZero;
    change(in);
    return contact::pulse_standard_errors(set, in).error().message;
  };
  CHECK_EQUAL("e must be from 0 to 1", complaint([](ContactInputs& in) { in.e = 1.01; }));
  CHECK_EQUAL("the simplified pulse needs e above 0", complaint([](ContactInputs& in) { in.e = 0.0; }));
  CHECK_EQUAL("dwell time must be positive", complaint([](ContactInputs& in) { in.dwell_time_s = 0.0; }));
  CHECK_EQUAL("dwell distance must be positive",
              complaint([](ContactInputs& in) { in.dwell_distance_m = 0.0; }));
  CHECK_EQUAL("diameter must be positive", complaint([](ContactInputs& in) { in.diameter_m = NAN; }));
  CHECK_EQUAL("inputs must be finite numbers", complaint([](ContactInputs& in) { in.mu = NAN; }));
  CHECK_EQUAL("vy must be negative: the ball must move towards the surface",
              complaint([](ContactInputs& in) { in.vy_td_mps = 6.7; }));
  const data::ContactSet one{.name = "one", .rows = {{0, 0, 0, 0}, {0.5, 0.5, -0.1, 0.5}, {1, 1, 0, 1}}};
  CHECK_EQUAL("at least two rows are needed between touchdown and lift-off",
              contact::pulse_standard_errors(one, kZero).error().message);
}
