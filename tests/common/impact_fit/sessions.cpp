#include "tests/common/impact_fit/sessions.hpp"

#include <cmath>

#include "common/impact/fit/fitter.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "tests/common/impact_fit/check.hpp"

namespace strobe::testing {

using namespace impact;

namespace {

/// Digitizing by hand: .5 mm and 1 degree.
constexpr double kByHand_mps = 0.24;
constexpr double kByHand_radps = 8.2;
constexpr int kVeryMany = 500;

class Generator {
 public:
  Generator(SessionKind kind, std::mt19937_64& source) : kind_(kind), source_(source) {}

  Session draw() {
    Session out;
    out.truth = {between(0.45, 0.65), between(0.0, 0.15), between(0.0015, 0.004), between(1.0, 5.0), 0.55};
    out.options = default_options(ReboundModel::grip_offset);
    if (kind_ != SessionKind::unstated) out.options.weighting = Weighting::stated_sd;
    noise_ = std::exp(between(std::log(0.25), 0.0));
    if (kind_ == SessionKind::contact) {
      contact_.mu = out.truth[index(Parameter::mu)];
      contact_.stiffness_ratio = between(1.2, 1.6);
      out.truth = best_match(out);
    }
    out.shots = conditions(out.truth, whole(12, 60));
    for (Observation& shot : out.shots) measure(shot);
    return out;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(source_);
  }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(source_); }
  double normal() { return normal_(source_); }

  /// The model's parameters that match very many contacts best.
  ParameterValues best_match(const Session& session) {
    std::vector<Observation> many = conditions(session.truth, kVeryMany);
    for (Observation& o : many) state_sds(o);
    Fitter fitter(many, session.options);
    fitter.search();
    return fitter.values();
  }

  std::vector<Observation> rebounds(std::vector<Observation> shots, const ParameterValues& p) const {
    if (kind_ != SessionKind::contact) return true_rebounds(std::move(shots), p);
    for (Observation& o : shots) {
      ContactCoefficients c = contact_;
      c.e = o.e;
      const auto contact = simulate({.alpha = kContactAlpha}, o.touchdown, c, {.tolerance = 1e-6});
      o.lift_off = contact.value().lift_off;
    }
    return shots;
  }

  /// The friction needed over that there is.
  std::pair<double, double> shares() const {
    if (kind_ == SessionKind::sliding) return {1.05, 4.0};
    if (kind_ == SessionKind::gripping) return {0.1, 0.95};
    return {0.5, 2.0};
  }

  Observation touchdown(const ParameterValues& p) {
    const auto [least, most] = shares();
    ParameterValues any_friction = p;
    any_friction[index(Parameter::mu)] = 50.0;
    for (;;) {
      Observation o;
      const double speed = between(15.0, 19.0), angle = between(0.2, 1.25);
      o.touchdown = {speed * std::cos(angle), -speed * std::sin(angle), between(-200.0, 250.0)};
      o.e = between(0.68, 0.9);
      const Observation gripping = true_rebounds({o}, any_friction).front();
      const double needed = std::abs(o.touchdown.vx_mps - gripping.lift_off.vx_mps) /
                            (gripping.lift_off.vy_mps - o.touchdown.vy_mps);
      const double share = needed / p[index(Parameter::mu)];
      if (share > least && share < most) return o;
    }
  }

  /// Shots with exact rebounds.
  std::vector<Observation> conditions(const ParameterValues& truth, int shots) {
    std::vector<Observation> out;
    if (kind_ == SessionKind::thesis) {
      const auto tables = testing::conditions();
      const int times = whole(1, 3);
      for (const Observation& o : tables)
        for (int i = 0; i < times; ++i) out.push_back(again(o));
      return rebounds(out, truth);
    }
    const bool repeats = kind_ == SessionKind::repeated || kind_ == SessionKind::scattered;
    const int count = kind_ == SessionKind::repeated    ? whole(3, 8)
                      : kind_ == SessionKind::scattered ? whole(8, 12)
                                                        : shots;
    for (int c = 0; c < count; ++c) {
      ParameterValues p = truth;
      if (kind_ == SessionKind::scattered) {
        p[index(Parameter::mu)] += 0.03 * normal();
        p[index(Parameter::e_x)] += 0.03 * normal();
      }
      const Observation first = touchdown(truth);
      const int times = repeats ? std::max(1, shots / count + whole(-1, 1)) : 1;
      for (int i = 0; i < times; ++i) {
        Observation shot = repeats ? again(first) : first;
        shot.series = std::to_string(c);
        if (kind_ == SessionKind::varying)
          p[index(Parameter::e_x)] = truth[index(Parameter::e_x)] + 0.05 * normal();
        out.push_back(rebounds({shot}, p).front());
      }
    }
    return out;
  }

  /// The machine throws a little otherwise each time.
  Observation again(Observation o) {
    o.touchdown.vx_mps += 0.3 * normal();
    o.touchdown.vy_mps += 0.3 * normal();
    o.touchdown.omega_radps += 8.0 * normal();
    o.e = std::min(0.98, o.e + 0.02 * normal());
    return o;
  }

  void state_sds(Observation& o) {
    for (auto sd : {&Observation::touchdown_sd, &Observation::lift_off_sd}) {
      const double level = noise_ * std::exp(0.4 * normal());
      (o.*sd) = {level * kByHand_mps, level * kByHand_mps, level * kByHand_radps};
    }
    o.e_sd = std::hypot(o.lift_off_sd.vy_mps, o.e * o.touchdown_sd.vy_mps) / std::abs(o.touchdown.vy_mps);
  }

  void measure(Observation& o) {
    state_sds(o);
    o.lift_off.vy_mps = -o.e * o.touchdown.vy_mps;
    for (auto [motion, sd] : {std::pair{&Observation::touchdown, &Observation::touchdown_sd},
                              std::pair{&Observation::lift_off, &Observation::lift_off_sd}}) {
      const double actual = kind_ == SessionKind::misstated ? 2.0 : 1.0;
      (o.*motion).vx_mps += actual * (o.*sd).vx_mps * normal();
      (o.*motion).vy_mps += actual * (o.*sd).vy_mps * normal();
      (o.*motion).omega_radps += actual * (o.*sd).omega_radps * normal();
    }
    o.e = std::min(1.0, -o.lift_off.vy_mps / o.touchdown.vy_mps);
    if (kind_ == SessionKind::unstated) o.touchdown_sd = o.lift_off_sd = {}, o.e_sd = 0.0;
  }

  SessionKind kind_;
  std::mt19937_64& source_;
  std::normal_distribution<double> normal_;
  double noise_ = 1.0;
  ContactCoefficients contact_;
};

}  // namespace

Session draw_session(SessionKind kind, std::mt19937_64& source) { return Generator(kind, source).draw(); }

void Coverage::add(const FittedParameter& fitted, double truth) {
  const int under = fitted.lower && truth < *fitted.lower ? 1 : 0;
  const int over = fitted.upper && truth > *fitted.upper ? 1 : 0;
  if (fitted.sd) {
    ++intervals;
    held += 1 - under - over;
    below += under;
    above += over;
    squares += std::pow((fitted.value - truth) / *fitted.sd, 2);
  } else if (fitted.lower || fitted.upper) {
    ++limits;
    limits_held += 1 - under - over;
  }
}

double Coverage::rms_z() const { return intervals > 0 ? std::sqrt(squares / intervals) : 0.0; }

}  // namespace strobe::testing
