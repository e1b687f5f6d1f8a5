#include "host/commands/predict/predict_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace strobe::host {

namespace {

/// Options of some models only.
struct ModelOption {
  const char* name;
  std::string_view models;
  bool physical;  ///< a property of ball or surface: may be given with --tolerance
};
constexpr std::array kModelOptions{ModelOption{"--ex", "grip", false},
                                   ModelOption{"--offset-mm", "grip", false},
                                   ModelOption{"--form", "pulse", false},
                                   ModelOption{"--ode-tolerance", "ode", false},
                                   ModelOption{"--method", "ode", false},
                                   ModelOption{"--ode-steps", "ode", false},
                                   ModelOption{"--mass-kg", "pulse or ode", true},
                                   ModelOption{"--dwell-time-ms", "pulse or ode", true},
                                   ModelOption{"--kt-ratio", "ode", true},
                                   ModelOption{"--ct", "ode", true},
                                   ModelOption{"--offset-footprint", "ode", true},
                                   ModelOption{"--offset-reference-mps", "ode", true},
                                   ModelOption{"--gravity-mps2", "ode", true},
                                   ModelOption{"--gravity-along-mps2", "ode", true}};

constexpr std::array kContactMethods{impact::ContactMethod::collocation,
                                     impact::ContactMethod::dormand_prince, impact::ContactMethod::rk4,
                                     impact::ContactMethod::semi_implicit_euler};

/// The model's default where the option is left out, for the help.
std::string defaults(double (*of)(std::string_view)) {
  return fmt::format("[{:.4g} for grip, {:.4g} for ode, {:.4g} otherwise]", of("grip"), of("ode"),
                     of("rigid"));
}

void add_model_options(CLI::App& command, PredictInput& o) {
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
  command.add_option("--form", o.form, "pulse: exact, or simplified as in the thesis")
      ->check(CLI::IsMember({"exact", "simplified"}));
}

/// By the names that the JSON tells.
void add_method_options(CLI::App& command, PredictOptions& options) {
  std::vector<std::string> names;
  for (const auto method : kContactMethods) names.emplace_back(impact::name(method));
  const auto choose = [&options](const std::string& text) {
    for (const auto method : kContactMethods)
      if (impact::name(method) == text) options.input.integration.method = method;
  };
  command
      .add_option_function<std::string>(
          "--method", choose,
          "ode: how the contact is computed: by collocation; by dormand_prince, the reference, which also "
          "takes over (the JSON's `method` says so) where collocation gives up; rk4 and "
          "semi_implicit_euler, with fixed steps, are for comparison")
      ->check(CLI::IsMember(names))
      ->default_str(names.front());
  command.add_option("--ode-steps", options.input.integration.steps,
                     "ode by rk4 or semi_implicit_euler: steps, 4 to 10000000");
}

void add_ode_options(CLI::App& command, PredictOptions& options) {
  PredictInput& o = options.input;
  command.add_option("--kt-ratio", o.contact.stiffness_ratio,
                     "ode: tangential over normal stiffness, 0.001 to 1000");
  command.add_option("--ct", o.contact.damping_ratio,
                     "ode: tangential damping over sqrt(kt m), 0 (none) or 0.01 to 10");
  command.add_option(
      "--offset-footprint", o.contact.offset_share,
      "ode: offset of the normal force over the footprint's radius at full turning speed, 0 to 1");
  command.add_option("--offset-reference-mps", o.contact.offset_reference_mps,
                     "ode: turning speed R omega at which 0.71 of that offset is reached, m/s");
  command.add_option("--gravity-mps2", o.contact.gravity_mps2, "ode: weight during the contact, m/s^2");
  command.add_option("--gravity-along-mps2", o.contact.gravity_along_mps2,
                     "ode: weight along an inclined surface, in the direction of +x, m/s^2");
  command.add_option("--ode-tolerance", o.integration.tolerance,
                     "ode: relative error that collocation and dormand_prince are held to, 1e-12 to 1e-3");
  add_method_options(command, options);
  command.add_option("--trajectory", options.trajectory_file,
                     "ode: write the trajectory of the contact to this CSV file");
  command
      .add_option(
          "--samples", options.samples,
          "ode: states from touchdown to release, equally spaced: in the file [201], else in the JSON "
          "as `trajectory`, else as CSV after the table")
      ->check(CLI::Range(2, 1'000'000))
      ->default_str("");
}

void add_choice_options(CLI::App& command, PredictOptions& options) {
  const std::string defaults_text =
      fmt::format("All models then take the mu ({:g}) and alpha ({:g}) of ode unless given",
                  default_mu("ode"), default_alpha("ode"));
  command.add_option(
      "--tolerance", options.tolerance,
      "choose the cheapest model and parameter with at most this error, as 0.1% or 1e-3: that of the "
      "lift-off's vx, vy and R omega together over the touchdown's speed, against the contact's mechanics "
      "(ode, exact). First by the largest over the contacts measured; where the deadline leaves time it is "
      "checked on this impact by a more exact run, which is taken instead if it shows more. What is promised "
      "for this impact and how that is known is told (JSON: `promised_error`, `promised_by`). " +
          defaults_text + "; --model restricts the choice to it");
  command.add_option(
      "--deadline-us", options.deadline_us,
      "choose a model and parameter that take at most this long, in microseconds as measured, checks "
      "included; without --tolerance the most exact such");
  command.add_option("--frontier", options.frontier_file,
                     "what the models cost and how exact they are, as `strobe-bench trade --frontier` writes "
                     "it; ranges.csv is read beside it [share/strobe/frontier/frontier.csv]");
}

std::string conflict_of_choice(const CLI::App& command, const PredictOptions& options) {
  for (const ModelOption& option : kModelOptions) {
    if (!option.physical && command.count(option.name) > 0)
      return fmt::format("{} is chosen with --tolerance or --deadline-us: leave it out", option.name);
  }
  if (options.deadline_us && !(*options.deadline_us > 0.0)) return "--deadline-us must be above 0";
  return {};
}

}  // namespace

void add_predict_options(CLI::App& command, PredictOptions& options) {
  PredictInput& in = options.input;
  command.add_option("--vx", in.touchdown.vx_mps, "Speed along the surface, m/s")->required();
  command.add_option("--vy", in.touchdown.vy_mps, "Speed normal to the surface, m/s; negative towards it")
      ->required();
  command.option_defaults()->always_capture_default();
  command.add_option("--omega", in.touchdown.omega_radps, "Spin, rad/s; backspin positive");
  add_model_options(command, in);
  add_ode_options(command, options);
  add_choice_options(command, options);
  command.add_flag("--json", options.json, "One JSON object on stdout");
}

std::string find_conflict(const CLI::App& command, PredictOptions& options) {
  options.model_given = command.count("--model") > 0;
  const std::string& model = options.input.model;
  const bool any_model = options.chooses() && !options.model_given;
  if (options.wants_trajectory() && model != "ode" && !any_model)
    return "--samples and --trajectory need --model ode";
  if (command.count("--frontier") > 0 && !options.chooses())
    return "--frontier is for --tolerance and --deadline-us";
  if (options.chooses()) return conflict_of_choice(command, options);
  for (const ModelOption& option : kModelOptions) {
    if (command.count(option.name) > 0 && option.models.find(model) == std::string_view::npos)
      return fmt::format("{} is for --model {}, not {}", option.name, option.models, model);
  }
  return {};
}

}  // namespace strobe::host
