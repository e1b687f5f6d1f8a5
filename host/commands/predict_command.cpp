// strobe predict: lift-off from touchdown by the impact models.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/impact/sine_pulse.hpp"
#include "common/units/angles.hpp"
#include "host/commands/command.hpp"
#include "host/commands/predict_ode.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

struct PredictOptions {
  impact::Motion touchdown;
  std::string model = "grip";
  double e = 0.75;
  std::optional<double> mu;
  std::optional<double> alpha;
  double e_x = impact::kFittedToThesis.e_x;
  double offset_mm = impact::kFittedToThesis.offset_m * 1e3;
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double dwell_time_ms = 5.0;
  std::string form = "exact";
  impact::ContactCoefficients contact;
  impact::ContactOptions integration;
  std::string trajectory_file;
  int samples = 0;
  bool json = false;
};

/// The thesis's rigid body has its thin shell; grip and ode were fitted with alpha of their own.
ball::Ball ball_of(const PredictOptions& o) {
  const double alpha = o.model == "grip"  ? ball::kMeasuredAlpha
                       : o.model == "ode" ? impact::kContactAlpha
                                          : ball::kThinShellAlpha;
  return {.diameter_m = o.diameter_m, .mass_kg = o.mass_kg, .alpha = o.alpha.value_or(alpha)};
}

double mu_of(const PredictOptions& o) {
  const double mu = o.model == "grip"  ? impact::kFittedToThesis.mu
                    : o.model == "ode" ? impact::ContactCoefficients{}.mu
                                       : 0.55;
  return o.mu.value_or(mu);
}

impact::ContactCoefficients contact_of(const PredictOptions& o) {
  impact::ContactCoefficients c = o.contact;
  c.e = o.e;
  c.mu = mu_of(o);
  c.dwell_s = o.dwell_time_ms / 1e3;
  return c;
}

struct Prediction {
  impact::Rebound rebound;
  std::optional<impact::PulseRebound> pulse = std::nullopt;
  std::optional<impact::ContactTrajectory> contact = std::nullopt;
};

tl::expected<Prediction, impact::InputError> predict(const PredictOptions& o) {
  const ball::Ball ball = ball_of(o);
  const double mu = mu_of(o);
  if (o.model == "pulse") {
    const auto form = o.form == "simplified" ? impact::PulseForm::simplified : impact::PulseForm::exact;
    return impact::pulse_rebound(form, ball, o.touchdown, o.e, mu, o.dwell_time_ms / 1e3)
        .map([](const impact::PulseRebound& p) { return Prediction{.rebound = p.rebound, .pulse = p}; });
  }
  if (o.model == "ode") {
    return impact::ContactTrajectory::make(ball, o.touchdown, contact_of(o), o.integration)
        .map([](impact::ContactTrajectory&& contact) {
          const impact::ContactSummary& s = contact.summary();
          return Prediction{.rebound = {.lift_off = s.lift_off,
                                        .regime = s.regime,
                                        .slip_lo_mps = s.slip_lo_mps,
                                        .impulse_ratio = s.impulse_ratio,
                                        .offset_m = s.mean_offset_m},
                            .contact = std::move(contact)};
        });
  }
  const auto rebound = o.model == "rigid"
                           ? impact::rigid(ball, o.touchdown, o.e, mu)
                           : impact::grip(ball, o.touchdown,
                                          {.e = o.e, .mu = mu, .e_x = o.e_x, .offset_m = o.offset_mm / 1e3});
  return rebound.map([](const impact::Rebound& r) { return Prediction{.rebound = r}; });
}

ordered_json inputs_of(const PredictOptions& o) {
  ordered_json in{{"vx_mps", o.touchdown.vx_mps},
                  {"vy_mps", o.touchdown.vy_mps},
                  {"omega_radps", o.touchdown.omega_radps},
                  {"model", o.model},
                  {"e", o.e},
                  {"mu", mu_of(o)},
                  {"alpha", ball_of(o).alpha},
                  {"diameter_m", o.diameter_m}};
  if (o.model == "grip") {
    in["ex"] = o.e_x;
    in["offset_mm"] = o.offset_mm;
    in["offset_reference_mps"] = impact::kOffsetReferenceSpeed_mps;
  }
  if (o.model == "pulse") {
    in["mass_kg"] = o.mass_kg;
    in["dwell_time_ms"] = o.dwell_time_ms;
    in["form"] = o.form;
  }
  if (o.model == "ode") {
    in["mass_kg"] = o.mass_kg;
    in["dwell_time_ms"] = o.dwell_time_ms;
    in["kt_ratio"] = o.contact.stiffness_ratio;
    in["ct"] = o.contact.damping_ratio;
    in["offset_footprint"] = o.contact.offset_share;
    in["offset_reference_mps"] = o.contact.offset_reference_mps;
    in["gravity_mps2"] = o.contact.gravity_mps2;
    in["tolerance"] = o.integration.tolerance;
  }
  return in;
}

void print_json(const PredictOptions& o, const Prediction& p) {
  const impact::Motion& lo = p.rebound.lift_off;
  ordered_json out{{"theta_out_deg", degrees(std::atan2(lo.vy_mps, lo.vx_mps))},
                   {"vx_lo_mps", lo.vx_mps},
                   {"vy_lo_mps", lo.vy_mps},
                   {"v_lo_mps", std::hypot(lo.vx_mps, lo.vy_mps)},
                   {"omega_lo_radps", lo.omega_radps},
                   {"slip_lo_mps", p.rebound.slip_lo_mps},
                   {"mu", p.rebound.impulse_ratio},
                   {"regime", impact::name(p.rebound.regime)}};
  if (p.pulse) {
    out["damping_f"] = p.pulse->damping_f;
    out["grip_fraction"] = p.pulse->grip_fraction;
    out["depth_m"] = p.pulse->depth_m;
    out["dwell_distance_cm"] = p.pulse->dwell_distance_m * 1e2;
    out["force_max_n"] = p.pulse->max_force_n;
  }
  if (p.contact) add_contact_json(out, *p.contact, o.trajectory_file.empty() ? o.samples : 0);
  out["inputs"] = inputs_of(o);
  std::printf("%s\n", out.dump().c_str());
}

void print_table(const PredictOptions& o, const Prediction& p) {
  const impact::Motion& td = o.touchdown;
  const impact::Motion& lo = p.rebound.lift_off;
  std::printf("model %s: e %g, mu %g, alpha %.4g, diameter %g m", o.model.c_str(), o.e, mu_of(o),
              ball_of(o).alpha, o.diameter_m);
  if (o.model == "grip") std::printf(", ex %g, offset %g mm", o.e_x, o.offset_mm);
  std::printf("\n             vx m/s    vy m/s     v m/s     angle  omega rad/s\n");
  const auto line = [](const char* when, const impact::Motion& m) {
    std::printf("%-10s %8.3f  %8.3f  %8.3f  %8.2f  %11.2f\n", when, m.vx_mps, m.vy_mps,
                std::hypot(m.vx_mps, m.vy_mps), degrees(std::atan2(m.vy_mps, m.vx_mps)), m.omega_radps);
  };
  line("touchdown", td);
  line("lift-off", lo);
  std::printf("%s; slip at lift-off %.3f m/s, impulse ratio %.4f\n", impact::name(p.rebound.regime).data(),
              p.rebound.slip_lo_mps, p.rebound.impulse_ratio);
  if (p.contact) print_contact(*p.contact);
  if (!p.pulse) return;
  std::printf(
      "pulse of %g ms, %s form: stops slipping at %.3f of it, %.1f mm deep, %.2f cm along, %.0f N at most\n",
      o.dwell_time_ms, o.form.c_str(), p.pulse->grip_fraction, p.pulse->depth_m * 1e3,
      p.pulse->dwell_distance_m * 1e2, p.pulse->max_force_n);
}

constexpr int kDefaultSamples = 201;

/// What of the course is asked for outside of the JSON: a file, or the table's rows.
int write_course(const PredictOptions& options, const impact::ContactTrajectory& contact) {
  if (options.trajectory_file.empty()) {
    if (options.samples > 0 && !options.json)
      std::fputs(contact_csv(contact, options.samples).c_str(), stdout);
    return kDone;
  }
  std::ofstream file(options.trajectory_file, std::ios::binary);
  file << contact_csv(contact, options.samples > 0 ? options.samples : kDefaultSamples);
  file.close();
  if (!file) return bad_input("predict: " + options.trajectory_file + ": cannot be written");
  return kDone;
}

int run_predict(const PredictOptions& options) {
  const bool course = options.samples > 0 || !options.trajectory_file.empty();
  if (course && options.model != "ode")
    return bad_input("predict: --samples and --trajectory need --model ode");
  const auto prediction = predict(options);
  if (!prediction) return bad_input("predict: " + std::string(impact::message(prediction.error())));
  if (!options.trajectory_file.empty()) {
    const int written = write_course(options, *prediction->contact);
    if (written != kDone) return written;
  }
  options.json ? print_json(options, *prediction) : print_table(options, *prediction);
  if (course && options.trajectory_file.empty()) return write_course(options, *prediction->contact);
  return kDone;
}

void add_model_options(CLI::App& command, PredictOptions& o) {
  command
      .add_option(
          "--model", o.model,
          "rigid: slides or rolls off; grip: with tangential restitution and an offset normal force, "
          "fitted to 21 conditions; pulse: rigid, with what happens in contact; ode: springs, dashpots, "
          "grip and slip through the contact, fitted to 21 conditions")
      ->check(CLI::IsMember({"rigid", "grip", "pulse", "ode"}))
      ->capture_default_str();
  command.add_option("--e", o.e, "Coefficient of restitution, 0 to 1 (ode: from 0.001)")
      ->capture_default_str();
  command.add_option("--mu", o.mu, "Coefficient of friction [0.57 for grip, 0.537 for ode, 0.55 otherwise]");
  command.add_option("--ex", o.e_x, "grip: tangential restitution, -1 to 1")->capture_default_str();
  command
      .add_option("--offset-mm", o.offset_mm,
                  "grip: normal force ahead of the centre at full rolling speed, mm")
      ->capture_default_str();
  command.add_option("--alpha", o.alpha,
                     "Moment of inertia over m R^2 [0.55 for grip, 0.579 for ode, 2/3 otherwise]");
  command.add_option("--diameter-m", o.diameter_m, "Diameter of the ball, m")->capture_default_str();
  command.add_option("--mass-kg", o.mass_kg, "pulse, ode: mass of the ball, kg")->capture_default_str();
  command.add_option("--dwell-time-ms", o.dwell_time_ms, "pulse, ode: touchdown to lift-off, ms")
      ->capture_default_str();
  command.add_option("--form", o.form, "pulse: exact, or simplified as in the thesis")
      ->check(CLI::IsMember({"exact", "simplified"}))
      ->capture_default_str();
}

void add_ode_options(CLI::App& command, PredictOptions& o) {
  command
      .add_option("--kt-ratio", o.contact.stiffness_ratio,
                  "ode: tangential over normal stiffness, 0.001 to 1000")
      ->capture_default_str();
  command
      .add_option("--ct", o.contact.damping_ratio,
                  "ode: tangential damping over sqrt(kt m), 0 (none) or 0.01 to 10")
      ->capture_default_str();
  command
      .add_option("--offset-footprint", o.contact.offset_share,
                  "ode: offset of the normal force over the footprint's radius at full turning speed, 0 to 1")
      ->capture_default_str();
  command
      .add_option("--offset-reference-mps", o.contact.offset_reference_mps,
                  "ode: turning speed R omega at which 0.71 of that offset is reached, m/s")
      ->capture_default_str();
  command.add_option("--gravity-mps2", o.contact.gravity_mps2, "ode: weight during the contact, m/s^2")
      ->capture_default_str();
  command
      .add_option("--tolerance", o.integration.tolerance,
                  "ode: relative error of the lift-off, 1e-12 to 1e-3")
      ->capture_default_str();
  command.add_option("--trajectory", o.trajectory_file,
                     "ode: write the course of the contact to this CSV file");
  command
      .add_option(
          "--samples", o.samples,
          "ode: states from touchdown to release, equally spaced: in the file [201], else in the JSON "
          "as `trajectory`, else as CSV after the table")
      ->check(CLI::Range(2, 1'000'000));
}

}  // namespace

void add_predict_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<PredictOptions>();
  CLI::App* command = app.add_subcommand("predict", "Predict the rebound from the motion at touchdown.");
  command->add_option("--vx", options->touchdown.vx_mps, "Speed along the surface, m/s")->required();
  command
      ->add_option("--vy", options->touchdown.vy_mps, "Speed normal to the surface, m/s; negative towards it")
      ->required();
  command->add_option("--omega", options->touchdown.omega_radps, "Spin, rad/s; backspin positive")
      ->capture_default_str();
  add_model_options(*command, *options);
  add_ode_options(*command, *options);
  command->add_flag("--json", options->json, "One JSON object on stdout");
  command->footer(
      "Examples: strobe predict --vx 15.62 --vy -6.71 --omega 2.6 --model grip --e 0.86\n"
      "          strobe predict --vx 14.49 --vy -9.95 --model ode --e 0.77 --dwell-time-ms 4.84 --samples "
      "11");
  command->callback([options, &exit_status] { exit_status = run_predict(*options); });
}

}  // namespace strobe::host
