// strobe predict: lift-off from touchdown by the impact models.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/command_line/help.hpp"
#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/frontier/frontier_files.hpp"
#include "host/commands/predict/predict_choice.hpp"
#include "host/commands/predict/predict_choice_report.hpp"
#include "host/commands/predict/predict_ode.hpp"
#include "host/commands/predict/predict_options.hpp"
#include "host/commands/terminal.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

ordered_json inputs_of(const PredictInput& o) {
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
  if (o.model == "ode" || o.model == "return_mapping") {
    in["mass_kg"] = o.mass_kg;
    in["dwell_time_ms"] = o.dwell_time_ms;
    in["kt_ratio"] = o.contact.stiffness_ratio;
    in["ct"] = o.contact.damping_ratio;
    in["offset_footprint"] = o.contact.offset_share;
    in["offset_reference_mps"] = o.contact.offset_reference_mps;
    in["gravity_mps2"] = o.contact.gravity_mps2;
    in["gravity_along_mps2"] = o.contact.gravity_along_mps2;
  }
  if (o.model == "return_mapping") in["steps"] = o.integration.steps;
  if (o.model == "ode") {
    const bool fixed_steps = o.integration.method == impact::ContactMethod::rk4 ||
                             o.integration.method == impact::ContactMethod::semi_implicit_euler;
    if (!fixed_steps) {
      in["tolerance"] = o.integration.tolerance;
    } else {
      in["integrator"] = o.integration.method == impact::ContactMethod::rk4 ? "rk4" : "euler";
      in["steps"] = o.integration.steps;
    }
    in["method"] = impact::name(o.integration.method);
  }
  return in;
}

ordered_json json_of(const PredictInput& in, const Prediction& p, int samples) {
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
  if (p.contact) add_contact_json(out, *p.contact, samples);
  out["inputs"] = inputs_of(in);
  return out;
}

void print_table(const PredictInput& o, const Prediction& p) {
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
  std::printf("%s; slip at lift-off %.3f m/s, impulse ratio %.4f\n", name(p.rebound.regime).data(),
              p.rebound.slip_lo_mps, p.rebound.impulse_ratio);
  if (p.contact) print_contact(*p.contact);
  if (p.contact && p.contact->summary().method != o.integration.method)
    std::printf("collocation gave up on this contact: computed by %s to 1e-12\n",
                impact::name(p.contact->summary().method).data());
  if (!p.pulse) return;
  std::printf(
      "pulse of %g ms, %s form: stops slipping at %.3f of it, %.1f mm deep, %.2f cm along, %.0f N at most\n",
      o.dwell_time_ms, o.form.c_str(), p.pulse->grip_fraction, p.pulse->depth_m * 1e3,
      p.pulse->dwell_distance_m * 1e2, p.pulse->max_force_n);
}

constexpr int kDefaultSamples = 201;

/// Writes the trajectory where it is not part of the JSON: to the file, or below the table.
int write_trajectory(const PredictOptions& options, const impact::ContactTrajectory& contact) {
  if (options.trajectory_file.empty()) {
    if (options.samples > 0 && !options.json)
      std::fputs(contact_csv(contact, options.samples).c_str(), stdout);
    return kDone;
  }
  const std::string csv = contact_csv(contact, options.samples > 0 ? options.samples : kDefaultSamples);
  const auto written = config::write_file(options.trajectory_file, csv);
  return written ? kDone : bad_input("predict: " + written.error().message);
}

/// Output about a choice besides the prediction; empty without one.
struct ChoiceOutput {
  ordered_json json;
  std::vector<std::string> lines;
};

int print_prediction(const PredictOptions& options, const PredictInput& in, const Prediction& prediction,
                     const ChoiceOutput& choice) {
  if (!options.trajectory_file.empty()) {
    const int written = write_trajectory(options, *prediction.contact);
    if (written != kDone) return written;
  }
  if (options.json) {
    ordered_json out = json_of(in, prediction, options.trajectory_file.empty() ? options.samples : 0);
    if (!choice.json.is_null()) out["choice"] = choice.json;
    std::printf("%s\n", messages::json_text(out).c_str());
  } else {
    print_table(in, prediction);
    for (const std::string& line : choice.lines) std::printf("%s\n", line.c_str());
  }
  if (options.wants_trajectory() && options.trajectory_file.empty())
    return write_trajectory(options, *prediction.contact);
  return kDone;
}

/// For stderr: times are not part of a result, whose bytes are reproducible.
std::string timing_line(const ImpactChoice& choice, const frontier::Requirement& requirement) {
  const double again_us = to_microseconds(choice.repeated_duration);
  std::string line = fmt::format(
      "strobe: predict: took {:.1f} us at its first call, {:.1f} us when repeated ({:.3g} us expected)",
      to_microseconds(choice.duration), again_us, choice.expected_cost_us);
  if (requirement.deadline_us && again_us > *requirement.deadline_us) line += ", past the deadline";
  return line + "\n";
}

int run_choice(const PredictOptions& options) {
  const auto requirement = parse_requirement(options.tolerance, options.deadline_us);
  if (!requirement) return bad_input("predict: " + requirement.error().message);
  const auto files = read_frontier(options.frontier_file);
  if (!files) return bad_input("predict: " + files.error().message);
  const std::string model = options.model_given          ? options.input.model
                            : options.wants_trajectory() ? "ode"
                                                         : "";
  const auto choice = choose_impact(measured_models(files->rows, files->ranges), *requirement, model,
                                    options.input, steady_now);
  if (!choice) return bad_input("predict: " + choice.error().message);
  const int status =
      print_prediction(options, choice->input, choice->prediction,
                       {choice_json(*choice, *requirement), choice_lines(*choice, *requirement)});
  std::fputs(timing_line(*choice, *requirement).c_str(), stderr);
  if (status != kDone || choice->within_tolerance.value_or(true)) return status;
  return failed("predict: " + frontier::label(choice->taken.row) + " misses the tolerance on this impact");
}

int run_predict(const PredictOptions& options) {
  if (options.chooses()) return run_choice(options);
  const auto prediction = predict(options.input);
  if (!prediction) return bad_input("predict: " + std::string(impact::message(prediction.error())));
  return print_prediction(options, options.input, *prediction, {});
}

}  // namespace

void add_predict_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<PredictOptions>();
  CLI::App* command = app.add_subcommand("predict", "Predict the rebound from the motion at touchdown.");
  add_predict_options(*command, *options);
  command_line::for_experts(
      *command,
      {"--form", "--kt-ratio", "--ct", "--offset-footprint", "--offset-reference-mps", "--gravity-mps2",
       "--gravity-along-mps2", "--ode-tolerance", "--method", "--ode-steps", "--trajectory", "--samples",
       "--tolerance", "--deadline-us", "--frontier", "--offset-mm", "--alpha"});
  command->footer(
      "Examples: strobe predict --vx 15.62 --vy -6.71 --omega 2.6 --model grip --e 0.86\n"
      "          strobe predict --vx 14.49 --vy -9.95 --model ode --e 0.77 --dwell-time-ms 4.84 --samples "
      "11\n"
      "          strobe predict --vx 15.62 --vy -6.71 --e 0.86 --tolerance 0.1% --deadline-us 50\n"
      "Exit status: 1 if --model restricts the choice to one that misses the tolerance on this impact, 2 for "
      "bad input and if no model meets tolerance and deadline.");
  command->callback([options, command, &exit_status] {
    const std::string wrong = find_conflict(*command, *options);
    exit_status = wrong.empty() ? run_predict(*options) : bad_input("predict: " + wrong);
  });
}

}  // namespace strobe::host
