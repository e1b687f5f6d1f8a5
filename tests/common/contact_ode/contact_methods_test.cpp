// The thesis's 21 conditions by each method: what the integrator gave when it was the only one is recorded in
// data/thesis_by_dormand_prince.csv (rebounds with the default coefficients, the fit, the fits without a spin).
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "common/impact/fit/contact_fit.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;

namespace {

/// Numbers by the first column.
std::map<std::string, std::vector<double>> recorded() {
  std::map<std::string, std::vector<double>> rows;
  std::ifstream file(STROBE_SOURCE_DIR "/tests/common/contact_ode/data/thesis_by_dormand_prince.csv");
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string name, cell;
    std::getline(cells, name, ',');
    if (name == "set") continue;
    while (std::getline(cells, cell, ',')) rows[name].push_back(std::stod(cell));
  }
  return rows;
}

std::vector<ContactObservation> conditions() {
  const auto data = thesis::load(STROBE_THESIS_FOLDER, thesis::Version::corrected);
  std::vector<ContactObservation> out;
  for (const thesis::Condition& c : data->conditions) out.push_back(observation_of(c));
  return out;
}

/// Of what a method to 1e-9 may be off, this share: all of it, or what another mathematical library's last bits do.
struct Method {
  ContactMethod method;
  double share;
};
constexpr Method kMethods[] = {{ContactMethod::collocation, 1.0}, {ContactMethod::dormand_prince, 1e-4}};

}  // namespace

TEST_GROUP(ContactMethods){};

// Two methods to 1e-9 of the scale of each motion, here of speeds that change by up to 25 m/s and energies by 6 J.
TEST(ContactMethods, TheReboundsOfTheConditionsAreThoseRecorded) {
  const auto rows = recorded();
  for (const auto& [method, share] : kMethods) {
    int compared = 0;
    for (const ContactObservation& o : conditions()) {
      const std::vector<double>& want = rows.at(o.name);
      const auto s = simulate({.alpha = kContactAlpha}, o.touchdown, {.e = o.e, .dwell_s = o.dwell_s},
                              {.method = method});
      const double speed = share * 2e-9 * 25.0, length = speed * o.dwell_s, radius = ball::Ball{}.radius_m();
      DOUBLES_EQUAL(want[0], s->lift_off.vx_mps, speed);
      DOUBLES_EQUAL(want[1], s->lift_off.vy_mps, speed);
      DOUBLES_EQUAL(want[2], s->lift_off.omega_radps, speed / radius);
      DOUBLES_EQUAL(want[3], s->dwell_s, share * 2e-9 * o.dwell_s);
      DOUBLES_EQUAL(want[4], s->dwell_distance_m, length);
      DOUBLES_EQUAL(want[5], s->rotation_rad, length / radius);
      DOUBLES_EQUAL(want[6], s->energy.dissipated_j(), share * 1e-8 * 6.0);
      ++compared;
    }
    LONGS_EQUAL(21, compared);
  }
}

// A minimum is as sharp as the root of what ends the search, 1e-10 of chi-square: 1e-5 of a parameter's sd.
TEST(ContactMethods, TheFitAndTheForecastsOfSpinsLeftOutAreThoseRecorded) {
  const auto rows = recorded();
  const auto all = conditions();
  for (const auto& [method, share] : kMethods) {
    const ContactFitOptions options{.method = method};
    const auto fit = fit_contact(all, options);
    const auto compare = [&, part = std::max(share, 0.01)](const std::vector<double>& want,
                                                           const ContactVector& value, double vx_rms_mps,
                                                           double omega_rms_radps) {
      for (int i = 0; i < kFitParameters; ++i)
        DOUBLES_EQUAL(want[static_cast<std::size_t>(i)], value[i],
                      part * 1e-5 * fit->sd(static_cast<ContactParameter>(i)));
      DOUBLES_EQUAL(want[5], vx_rms_mps, 1e-6);
      DOUBLES_EQUAL(want[6], omega_rms_radps, 3e-5);
    };
    compare(rows.at("fit"), fit->value, fit->vx_rms_mps, fit->omega_rms_radps);
    const auto left_out = leave_one_group_out(all, options);
    LONGS_EQUAL(3, left_out->size());
    for (const ContactHeldOutGroup& g : *left_out)
      compare(rows.at(g.group), g.value, g.vx_rms_mps, g.omega_rms_radps);
  }
}
