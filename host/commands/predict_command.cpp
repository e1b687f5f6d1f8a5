// strobe predict: lift-off from touchdown by the impact models.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/data/ball_kind.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "host/commands/command.hpp"
#include "host/commands/prediction.hpp"

namespace strobe::host {

using nlohmann::ordered_json;

namespace prediction {

double default_alpha(std::string_view model) {
  if (model == "grip") return ball::kMeasuredAlpha;
  return model == "ode" ? impact::kContactAlpha : ball::kThinShellAlpha;
}

double default_mu(std::string_view model) {
  constexpr double kThesisMean = 0.55;
  if (model == "grip") return impact::kFittedToThesis.mu;
  return model == "ode" ? impact::ContactCoefficients{}.mu : kThesisMean;
}

double alpha_of(const PredictOptions& o) { return o.alpha.value_or(default_alpha(o.model)); }
double mu_of(const PredictOptions& o) { return o.mu.value_or(default_mu(o.model)); }

ball::Ball ball_of(const PredictOptions& o) {
  return {.diameter_m = o.diameter_m, .mass_kg = o.mass_kg, .alpha = alpha_of(o)};
}

impact::ContactCoefficients contact_of(const PredictOptions& o) {
  impact::ContactCoefficients c = o.contact;
  c.e = o.e;
  c.mu = mu_of(o);
  c.dwell_s = o.dwell_time_ms / 1e3;
  return c;
}

impact::Coefficients grip_of(const PredictOptions& o) {
  return {.e = o.e, .mu = mu_of(o), .e_x = o.e_x, .offset_m = o.offset_mm / 1e3};
}

ordered_json inputs_of(const PredictOptions& o) {
  ordered_json in{{"vx_mps", o.touchdown.vx_mps},
                  {"vy_mps", o.touchdown.vy_mps},
                  {"omega_radps", o.touchdown.omega_radps},
                  {"model", o.model},
                  {"e", o.e},
                  {"mu", mu_of(o)},
                  {"alpha", alpha_of(o)},
                  {"diameter_m", o.diameter_m}};
  if (!o.ball.empty()) in["ball"] = o.ball;
  if (o.model == "grip") {
    in["ex"] = o.e_x;
    in["offset_mm"] = o.offset_mm;
    in["offset_reference_mps"] = impact::kOffsetReferenceSpeed_mps;
  }
  if (o.model == "pulse" || o.model == "ode") {
    in["mass_kg"] = o.mass_kg;
    in["dwell_time_ms"] = o.dwell_time_ms;
  }
  if (o.model == "pulse") in["form"] = "exact";
  if (o.model == "ode") {
    in["kt_ratio"] = o.contact.stiffness_ratio;
    in["ct"] = o.contact.damping_ratio;
    in["offset_footprint"] = o.contact.offset_share;
    in["offset_reference_mps"] = o.contact.offset_reference_mps;
    in["gravity_mps2"] = o.contact.gravity_mps2;
    in["gravity_along_mps2"] = o.contact.gravity_along_mps2;
    in["tolerance"] = o.integration.tolerance;
    in["method"] = impact::name(o.integration.method);
  }
  return in;
}

ordered_json milliseconds_json(const std::optional<double>& time_s) {
  return time_s ? ordered_json(*time_s * 1e3) : ordered_json(nullptr);
}

ordered_json energy_json(const impact::ContactEnergy& e) {
  return {{"kinetic_td_j", e.kinetic_td_j},
          {"kinetic_lo_j", e.kinetic_lo_j},
          {"kinetic_lost_j", e.kinetic_lost_j},
          {"normal_damping_j", e.normal_damping_j},
          {"normal_spring_left_j", e.normal_spring_left_j},
          {"sliding_j", e.sliding_j},
          {"tangential_damping_j", e.tangential_damping_j},
          {"tangential_spring_left_j", e.tangential_spring_left_j},
          {"offset_j", e.offset_j},
          {"gravity_work_j", e.gravity_work_j}};
}

void print_model(const PredictOptions& o) {
  std::printf("model %s: e %g, mu %g, alpha %.4g, diameter %g m", o.model.c_str(), o.e, mu_of(o), alpha_of(o),
              o.diameter_m);
  if (o.model == "grip") std::printf(", ex %g, offset %g mm", o.e_x, o.offset_mm);
}

}  // namespace prediction

namespace {

using namespace prediction;

struct Prediction {
  impact::Rebound rebound;
  std::optional<impact::PulseRebound> pulse = std::nullopt;
  std::optional<impact::ContactTrajectory> contact = std::nullopt;
};

Prediction of_contact(impact::ContactTrajectory&& contact) {
  const impact::ContactSummary& s = contact.summary();
  return {.rebound = {.lift_off = s.lift_off,
                      .regime = s.regime,
                      .slip_lo_mps = s.slip_lo_mps,
                      .impulse_ratio = s.impulse_ratio,
                      .offset_m = s.mean_offset_m},
          .contact = std::move(contact)};
}

tl::expected<Prediction, impact::InputError> predict(const PredictOptions& o) {
  const ball::Ball ball = ball_of(o);
  const double mu = mu_of(o);
  if (o.model == "pulse")
    return impact::pulse_rebound(impact::PulseForm::exact, ball, o.touchdown, o.e, mu, o.dwell_time_ms / 1e3)
        .map([](const impact::PulseRebound& p) { return Prediction{.rebound = p.rebound, .pulse = p}; });
  if (o.model == "ode")
    return impact::ContactTrajectory::make(ball, o.touchdown, contact_of(o), o.integration).map(of_contact);
  const auto rebound = o.model == "rigid" ? impact::rigid(ball, o.touchdown, o.e, mu)
                                          : impact::grip(ball, o.touchdown, grip_of(o));
  return rebound.map([&](impact::Rebound r) {
    r.regime = impact::regime_of(ball, o.touchdown, r);
    return Prediction{.rebound = r};
  });
}

/// The i-th of n > 1 states from touchdown to release, equally spaced in time, by the names of its columns.
ordered_json state_json(const impact::ContactTrajectory& contact, int i, int n) {
  const impact::ContactState s = contact.at(contact.summary().dwell_s * i / (n - 1));
  return {{"time_ms", s.time_s * 1e3},
          {"x_m", s.x_m},
          {"y_m", s.y_m},
          {"angle_deg", degrees(s.rotation_rad)},
          {"vx_mps", s.vx_mps},
          {"vy_mps", s.vy_mps},
          {"omega_radps", s.omega_radps},
          {"fx_n", s.fx_n},
          {"fy_n", s.fy_n},
          {"mode", impact::name(s.mode)}};
}

void add_contact_json(ordered_json& out, const impact::ContactTrajectory& contact, int samples) {
  const impact::ContactSummary& s = contact.summary();
  out["skid_to_grip_ms"] = milliseconds_json(s.skid_to_grip_s);
  out["slip_zero_ms"] = milliseconds_json(s.slip_zero_s);
  out["friction_reversals"] = s.friction_reversals;
  out["dwell_time_ms"] = s.dwell_s * 1e3;
  out["dwell_distance_cm"] = s.dwell_distance_m * 1e2;
  out["rotation_deg"] = degrees(s.rotation_rad);
  out["depth_m"] = s.max_depth_m;
  out["depth_time_ms"] = s.max_depth_time_s * 1e3;
  out["force_max_n"] = s.max_force_n;
  out["force_max_time_ms"] = s.max_force_time_s * 1e3;
  out["friction_max_n"] = s.max_friction_n;
  out["mean_offset_mm"] = s.mean_offset_m * 1e3;
  out["events"] = ordered_json::array();
  for (const impact::ContactEvent& event : s.event_list())
    out["events"].push_back({{"time_ms", event.time_s * 1e3}, {"event", impact::name(event.kind)}});
  out["events_left_out"] = s.events_left_out;
  out["energy"] = energy_json(s.energy);
  out["steps"] = s.steps;
  out["method"] = impact::name(s.method);
  for (int i = 0; i < samples; ++i) out["trajectory"].push_back(state_json(contact, i, samples));
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
                   {"regime", name(p.rebound.regime)}};
  if (p.pulse) {
    out["damping_f"] = p.pulse->damping_f;
    out["grip_fraction"] = p.pulse->grip_fraction;
    out["depth_m"] = p.pulse->depth_m;
    out["dwell_distance_cm"] = p.pulse->dwell_distance_m * 1e2;
    out["force_max_n"] = p.pulse->max_force_n;
  }
  if (p.contact) add_contact_json(out, *p.contact, o.samples);
  out["inputs"] = inputs_of(o);
  if (!o.remarks.empty()) out["remarks"] = o.remarks;
  std::printf("%s\n", messages::json_text(out).c_str());
}

void print_contact(const impact::ContactTrajectory& contact) {
  const impact::ContactSummary& s = contact.summary();
  std::printf("contact of %.3f ms: %.1f mm deep, %.2f cm along, turned %.1f degrees, %.0f N at most\n",
              s.dwell_s * 1e3, s.max_depth_m * 1e3, s.dwell_distance_m * 1e2, degrees(s.rotation_rad),
              s.max_force_n);
  for (const impact::ContactEvent& event : s.event_list())
    std::printf("  %8.4f ms  %s\n", event.time_s * 1e3, impact::name(event.kind).data());
  if (s.events_left_out > 0)
    std::printf("  and %d more grips, slips and reversals; %d reversals in all\n", s.events_left_out,
                s.friction_reversals);
  const impact::ContactEnergy& e = s.energy;
  std::printf(
      "energy %.4f J, of which lost: %.4f normal damping, %.4f sliding, %.4f tangential damping, %.4f "
      "offset,\n"
      "  %.4f and %.4f left in the normal and tangential springs; sum %.4f of %.4f\n",
      e.kinetic_td_j, e.normal_damping_j, e.sliding_j, e.tangential_damping_j, e.offset_j,
      e.normal_spring_left_j, e.tangential_spring_left_j, e.dissipated_j(), e.kinetic_lost_j);
}

/// A header and a row for each state.
void print_trajectory(const impact::ContactTrajectory& contact, int samples) {
  for (int i = 0; i < samples; ++i) {
    const ordered_json state = state_json(contact, i, samples);
    std::string names, values;
    for (const auto& [name, value] : state.get_ref<const ordered_json::object_t&>()) {
      const std::string text =
          value.is_string() ? value.get<std::string>() : fmt::format("{}", value.get<double>());
      names += (names.empty() ? "" : ",") + name;
      values += (values.empty() ? "" : ",") + text;
    }
    if (i == 0) std::printf("%s\n", names.c_str());
    std::printf("%s\n", values.c_str());
  }
}

void print_table(const PredictOptions& o, const Prediction& p) {
  print_model(o);
  std::printf("\n             vx m/s    vy m/s     v m/s angle deg  omega rad/s\n");
  const auto line = [](const char* when, const impact::Motion& m) {
    std::printf("%-10s %8.3f  %8.3f  %8.3f  %8.2f  %11.2f\n", when, m.vx_mps, m.vy_mps,
                std::hypot(m.vx_mps, m.vy_mps), degrees(std::atan2(m.vy_mps, m.vx_mps)), m.omega_radps);
  };
  line("touchdown", o.touchdown);
  line("lift-off", p.rebound.lift_off);
  std::printf("%s; slip at lift-off %.3f m/s, impulse ratio %.4f\n", name(p.rebound.regime).data(),
              p.rebound.slip_lo_mps, p.rebound.impulse_ratio);
  if (p.contact) {
    print_contact(*p.contact);
    if (p.contact->summary().method != o.integration.method)
      std::printf("collocation gave up on this contact: computed by %s to 1e-12\n",
                  impact::name(p.contact->summary().method).data());
    print_trajectory(*p.contact, o.samples);
  }
  if (p.pulse)
    std::printf(
        "pulse of %g ms, exact form: stops slipping at %.3f of it, %.1f mm deep, %.2f cm along, %.0f N at "
        "most\n",
        o.dwell_time_ms, p.pulse->grip_fraction, p.pulse->depth_m * 1e3, p.pulse->dwell_distance_m * 1e2,
        p.pulse->max_force_n);
}

/// Options of some models only.
struct ModelOption {
  const char* name;
  std::string_view models;
};
constexpr std::array kModelOptions{ModelOption{"--vz", "rigid, grip or ode"},
                                   ModelOption{"--omega-x", "rigid, grip or ode"},
                                   ModelOption{"--omega-y", "rigid, grip or ode"},
                                   ModelOption{"--ex", "grip"},
                                   ModelOption{"--offset-mm", "grip"},
                                   ModelOption{"--mass-kg", "pulse or ode"},
                                   ModelOption{"--dwell-time-ms", "pulse or ode"},
                                   ModelOption{"--ct", "ode"},
                                   ModelOption{"--ode-tolerance", "ode"},
                                   ModelOption{"--method", "ode"},
                                   ModelOption{"--samples", "ode"}};

/// What goes with another model than the one chosen; empty: nothing.
std::string conflict_of(const CLI::App& command, const std::string& model) {
  for (const ModelOption& option : kModelOptions)
    if (command.count(option.name) > 0 && option.models.find(model) == std::string_view::npos)
      return fmt::format("{} is for --model {}, not {}", option.name, option.models, model);
  return {};
}

/// The model's default where the option is left out, for the help.
std::string defaults(double (*of)(std::string_view)) {
  return fmt::format("[{:.4g} for grip, {:.4g} for ode, {:.4g} otherwise]", of("grip"), of("ode"),
                     of("rigid"));
}

void add_ode_options(CLI::App& command, PredictOptions& o) {
  // Kept because it shows what the published bounces say against the fitted dashpot (common/data/bounces).
  command.add_option("--ct", o.contact.damping_ratio,
                     "ode: tangential damping over sqrt(kt m), 0 (none) or 0.01 to 10");
  command.add_option("--ode-tolerance", o.integration.tolerance,
                     "ode: relative error that its solver is held to, 1e-12 to 1e-3");
  const auto reference = impact::ContactMethod::dormand_prince;
  command
      .add_option_function<std::string>(
          "--method",
          [&o, reference](const std::string& text) {
            o.integration.method =
                text == impact::name(reference) ? reference : impact::ContactMethod::collocation;
          },
          "ode: how the contact is computed: by collocation; or by dormand_prince, the reference, which also "
          "takes over (the JSON's `method` says so) where collocation gives up")
      ->check(CLI::IsMember({"collocation", "dormand_prince"}))
      ->default_str("collocation");
  command
      .add_option("--samples", o.samples,
                  "ode: states from touchdown to release, equally spaced: in the JSON as `trajectory`, else "
                  "as CSV after the table")
      ->check(CLI::Range(2, 1'000'000))
      ->default_str("");
}

void add_options(CLI::App& command, PredictOptions& o) {
  command.add_option("--vx", o.touchdown.vx_mps, "Speed along the surface, m/s")->required();
  command.add_option("--vy", o.touchdown.vy_mps, "Speed normal to the surface, m/s; negative towards it")
      ->required();
  command.add_option("--ball", o.ball,
                     "Kind of ball (strobe ball lists them): its size, mass, inertia, e, mu and dwell time, "
                     "where they are not given");
  command.option_defaults()->always_capture_default();
  command.add_option("--omega", o.touchdown.omega_radps, "Spin, rad/s; backspin positive");
  command.add_option("--vz", o.vz_mps, "Speed along the surface across x, towards the camera, m/s");
  command.add_option("--omega-x", o.omega_x_radps, "Spin about x, right-handed, rad/s");
  command.add_option("--omega-y", o.omega_y_radps, "Spin about the normal, right-handed, rad/s");
  command
      .add_option(
          "--model", o.model,
          "rigid: slides or rolls off; grip: with tangential restitution and an offset normal force, "
          "fitted to 21 conditions; pulse: rigid, with what happens in contact; ode: springs, dashpots, "
          "grip and slip through the contact, fitted to 21 conditions")
      ->check(CLI::IsMember({"rigid", "grip", "pulse", "ode"}));
  command.add_option("--e", o.e, "Coefficient of restitution, 0 to 1 (ode: from 0.001)");
  command.add_option("--mu", o.mu, "Coefficient of friction " + defaults(default_mu));
  command.add_option("--ex", o.e_x, "grip: tangential restitution, -1 to 1");
  command.add_option("--offset-mm", o.offset_mm,
                     "grip: normal force ahead of the centre at full rolling speed, mm");
  command.add_option("--alpha", o.alpha, "Moment of inertia over m R^2 " + defaults(default_alpha));
  command.add_option("--diameter-m", o.diameter_m, "Diameter of the ball, m");
  command.add_option("--mass-kg", o.mass_kg, "pulse, ode: mass of the ball, kg");
  command.add_option("--dwell-time-ms", o.dwell_time_ms, "pulse, ode: touchdown to lift-off, ms");
  add_ode_options(command, o);
  command.add_flag("--json", o.json, "One JSON object on stdout");
}

/// What the kind says of what was not given.
Result<void> take_ball(const CLI::App& command, PredictOptions& o) {
  const auto kind = balls::load_ball_kind(o.ball);
  if (!kind) return fail("--ball: " + kind.error().message);
  const auto absent = [&command](const char* name) { return command.count(name) == 0; };
  if (absent("--diameter-m")) o.diameter_m = kind->diameter_m.value;
  if (absent("--mass-kg")) o.mass_kg = kind->mass_kg.value;
  if (!o.alpha) o.alpha = kind->alpha.value;
  if (absent("--e")) o.e = kind->contact.e;
  if (!o.mu) o.mu = kind->contact.mu;
  if (absent("--dwell-time-ms")) o.dwell_time_ms = 1e3 * kind->contact.dwell_s;
  o.remarks = balls::beyond_ranges(*kind, std::nullopt, std::abs(o.touchdown.vy_mps));
  if (o.model == "grip" || o.model == "ode")
    o.remarks.push_back(kind->name + ": what else the model needs was fitted to tennis balls");
  return {};
}

int run_predict(const CLI::App& command, PredictOptions& o) {
  const std::string conflict = conflict_of(command, o.model);
  if (!conflict.empty()) return bad_input("predict: " + conflict);
  if (!o.ball.empty()) {
    if (const auto taken = take_ball(command, o); !taken)
      return bad_input("predict: " + taken.error().message);
    if (!o.json)
      for (const std::string& remark : o.remarks) std::fprintf(stderr, "strobe: %s\n", remark.c_str());
  }
  if (is_spatial(o)) {
    for (const char* planar : {"--method", "--samples"})
      if (command.count(planar) > 0)
        return bad_input(fmt::format("predict: {} is for motion in the plane", planar));
    return predict_spatial(o);
  }
  const auto prediction = predict(o);
  if (!prediction) return bad_input("predict: " + std::string(impact::message(prediction.error())));
  o.json ? print_json(o, *prediction) : print_table(o, *prediction);
  return kDone;
}

}  // namespace

void add_predict_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<PredictOptions>();
  CLI::App* command = app.add_subcommand("predict", "Predict the rebound from the motion at touchdown.");
  add_options(*command, *options);
  command_line::for_experts(
      *command, {"--ct", "--ode-tolerance", "--method", "--samples", "--offset-mm", "--alpha", "--omega-y"});
  command->footer(
      "Examples: strobe predict --vx 15.62 --vy -6.71 --omega 2.6 --model grip --e 0.86\n"
      "          strobe predict --vx 14.49 --vy -9.95 --model ode --e 0.77 --dwell-time-ms 4.84 --samples "
      "11\n"
      "          strobe predict --vx 15 --vy -7 --omega-x 80");
  command->callback([options, command, &exit_status] { exit_status = run_predict(*command, *options); });
}

}  // namespace strobe::host
