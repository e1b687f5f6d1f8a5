// strobe fit: friction, restitution and rolling friction from measured rebounds.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>

#include "common/command_line/command_line.hpp"
#include "common/flight/gravity.hpp"
#include "common/impact/fit/model_fit.hpp"
#include "host/commands/command.hpp"
#include "host/commands/fit_report.hpp"

namespace strobe::host {

namespace {

using impact::FitError;
using impact::FitFailure;
using impact::kParameterCount;
using impact::Parameter;
using impact::ReboundModel;

struct Arguments {
  std::vector<std::string> files;
  std::string model = "grip-offset";
  std::vector<std::string> free;
  std::vector<std::string> fix;
  std::string leave_one_group_out = "none";
  std::string weights = "auto";
  std::string covariance = "clustered";
  std::string spread = "replicate";
  std::string spin;
  std::string sampler = "auto";
  std::uint64_t seed = 1;
  int draws = 0;
  double diameter_m = ball::kThesisDiameter_m;
  double gravity_mps2 = flight::kStandardGravity_mps2;
  bool as_printed = false;
  bool json = false;
  std::vector<const CLI::Option*> of_ode{};  ///< options that the other models do not have
};

ReboundModel model_of(const std::string& text) {
  for (const ReboundModel m : {ReboundModel::slide_roll, ReboundModel::grip, ReboundModel::ode})
    if (text == impact::name(m)) return m;
  return ReboundModel::grip_offset;
}

/// "mu, ex, d, u0 and alpha"
std::string parameter_names(ReboundModel model) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kParameterCount; ++i)
    if (impact::has_parameter(model, static_cast<Parameter>(i)))
      names.push_back(impact::name(static_cast<Parameter>(i)));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

Result<Parameter> parameter_of(const std::string& text, ReboundModel model) {
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    const auto p = static_cast<Parameter>(i);
    if (text == impact::name(p)) return p;
  }
  return fail("fit: --free, --fix: no parameter \"" + text + "\"; there are " + parameter_names(model));
}

/// "name=value" with d in mm and dwell in ms.
Result<std::pair<Parameter, double>> fixed_value(const std::string& text, ReboundModel model) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return fail("fit: --fix " + text + ": must be name=value");
  const auto p = parameter_of(text.substr(0, equals), model);
  if (!p) return tl::unexpected(p.error());
  double value = 0.0;
  const char* begin = text.data() + equals + 1;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(begin, end, value);
  if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(value))
    return fail("fit: --fix " + text + ": the value is not a number");
  return std::pair(*p, from_display_unit(*p, value));
}

impact::PosteriorMethod sampler_of(const std::string& text) {
  using impact::PosteriorMethod;
  for (const PosteriorMethod m :
       {PosteriorMethod::laplace, PosteriorMethod::importance, PosteriorMethod::metropolis})
    if (text == impact::name(m)) return m;
  return PosteriorMethod::automatic;
}

Result<impact::FitOptions> options_of(const Arguments& a) {
  impact::FitOptions out = impact::default_options(model_of(a.model));
  out.diameter_m = a.diameter_m;
  if (a.weights == "sd") out.weighting = impact::Weighting::stated_sd;
  if (a.covariance == "residuals") out.scale = impact::CovarianceScale::residuals;
  if (a.covariance == "stated") out.scale = impact::CovarianceScale::stated;
  out.posterior.method = sampler_of(a.sampler);
  out.posterior.seed = a.seed;
  out.posterior.draws = a.draws;
  impact::FreeParameters asked{};
  for (const std::string& text : a.free) {
    const auto p = parameter_of(text, out.model);
    if (!p) return tl::unexpected(p.error());
    asked[impact::index(*p)] = true;
  }
  if (!a.free.empty()) out.free = asked;
  for (const std::string& text : a.fix) {
    const auto fixed = fixed_value(text, out.model);
    if (!fixed) return tl::unexpected(fixed.error());
    const std::size_t i = impact::index(fixed->first);
    if (asked[i])
      return fail("fit: " + std::string(impact::name(fixed->first)) + " is in both --free and --fix");
    if (!impact::has_parameter(out.model, fixed->first))
      return fail("fit: " + std::string(impact::name(fixed->first)) +
                  ": the model does not have this parameter");
    const double lowest = to_display_unit(fixed->first, impact::lower_bound(fixed->first));
    const double highest =
        to_display_unit(fixed->first, impact::upper_bound(fixed->first, 0.5 * a.diameter_m));
    const double given = to_display_unit(fixed->first, fixed->second);
    if (given < lowest || given > highest)
      return fail(fmt::format("fit: --fix {}: must be from {} to {:.4g}{}", text, lowest, highest,
                              display_unit(fixed->first)));
    out.start[i] = fixed->second;
    out.free[i] = false;
  }
  return out;
}

Result<FitData> data_of(const Arguments& a) {
  if (a.files.empty())
    return conditions_to_fit(a.as_printed ? thesis::Version::as_printed : thesis::Version::corrected,
                             a.spread == "mean" ? impact::Spread::mean : impact::Spread::replicate);
  FitData out;
  for (const std::string& file : a.files) {
    auto data = read_results(file);
    if (!data) return tl::unexpected(data.error());
    if (data->observations.empty())
      return fail(file + ": no shot with vx, vy, omega at touchdown, vx, omega at lift-off and e");
    out.rejected += data->rejected;
    out.incomplete += data->incomplete;
    std::move(data->observations.begin(), data->observations.end(), std::back_inserter(out.observations));
  }
  return out;
}

/// The plate is taken for level.
void add_weight(const Arguments& a, FitData& data) {
  for (impact::Observation& o : data.observations) o.gravity_mps2 = a.gravity_mps2;
}

/// By the sds where every shot has them. Those of the thesis's conditions are the machine's spread, which
/// touchdown and lift-off share: no errors of the comparison.
void weigh_by_sd_where_stated(const Arguments& a, const FitData& data, impact::FitOptions& options) {
  if (a.weights != "auto" || a.files.empty()) return;
  const bool stated =
      std::all_of(data.observations.begin(), data.observations.end(), [](const impact::Observation& o) {
        return o.lift_off_sd.vx_mps > 0.0 && o.lift_off_sd.omega_radps > 0.0;
      });
  if (stated) options.weighting = impact::Weighting::stated_sd;
}

/// A shot whose numbers no impact can have, as e above 1 by its noise, is told and left out: the others can
/// be fitted.
void leave_impossible_out(const impact::FitOptions& options, FitData& data) {
  std::erase_if(data.observations, [&](const impact::Observation& o) {
    const auto failure = impact::find_observation_failure(o, 0, options);
    if (!failure || failure->error != FitError::invalid_observation) return false;
    data.impossible.push_back(impact::message(*failure, {&o, 1}));
    return true;
  });
}

int explain(const FitFailure& failure, const FitData& data) {
  std::string what = "fit: " + impact::message(failure, data.observations);
  if (!data.repeated.empty()) what += fmt::format(" ({})", fmt::join(data.repeated, "; "));
  return failure.error == FitError::not_identifiable ? failed(what) : bad_input(what);
}

/// On a terminal only.
sampling::Progress progress_after_two_seconds() {
  if (::isatty(STDERR_FILENO) != 1) return {};
  using Clock = std::chrono::steady_clock;
  return [start = Clock::now(), told = Clock::time_point()](double share) mutable {
    const auto now = Clock::now();
    if (now - start < std::chrono::seconds(2) || now - told < std::chrono::milliseconds(500)) return;
    told = now;
    fmt::print(stderr, "\rstrobe: drawing from the posterior: {:3.0f} % \r", 100.0 * share);
  };
}

/// Regimes and rolling friction of each observation; the fit has checked the observations.
void judge(FitReport& report) {
  const double alpha = report.fit.parameters[impact::index(Parameter::alpha)].value;
  const ball::Ball ball{.diameter_m = report.options.diameter_m, .alpha = alpha};
  for (const impact::Observation& o : report.data.observations) {
    report.regimes.push_back(
        impact::classify_regime(o, report.options.model, report.fit, report.options.diameter_m).value());
    report.rolling_friction.push_back(impact::rolling_friction(o, ball).value());
  }
}

int run_fit(const Arguments& a) {
  auto options = options_of(a);
  if (!options) return bad_input(options.error().message);
  for (const CLI::Option* option : a.of_ode)
    if (options->model != ReboundModel::ode && option->count() > 0)
      return bad_input("fit: " + option->get_name() + ": only --model ode has it");
  options->posterior.progress = progress_after_two_seconds();
  auto data = data_of(a);
  if (!data) return bad_input(data.error().message);
  if (!a.spin.empty()) data->observations = impact::of_spin(data->observations, a.spin);
  if (data->observations.empty()) return bad_input("fit: no observations of " + a.spin + " spin");
  data->repeated = impact::leave_copies_out(data->observations);
  if (options->model == ReboundModel::ode) add_weight(a, *data);
  weigh_by_sd_where_stated(a, *data, *options);
  leave_impossible_out(*options, *data);
  if (data->observations.empty())
    return bad_input("fit: " + data->impossible.front() + ", and no other shot is left");

  FitReport report;
  report.data = *std::move(data);
  report.options = *options;
  auto fit = impact::fit(report.data.observations, report.options);
  if (!fit) return explain(fit.error(), report.data);
  report.fit = *std::move(fit);
  judge(report);
  if (a.leave_one_group_out != "none") {
    report.grouped_by = a.leave_one_group_out == "spin" ? impact::CrossValidationGroup::spin
                                                        : impact::CrossValidationGroup::series;
    auto validation =
        impact::leave_one_group_out(report.data.observations, report.options, report.grouped_by);
    if (!validation) return explain(validation.error(), report.data);
    report.validation = *std::move(validation);
  }
  a.json ? print_fit_json(report) : print_fit_text(report);
  return converged(report.fit.termination) ? kDone : kFailed;
}

void add_model_options(CLI::App& command, Arguments& a) {
  command
      .add_option("--model", a.model,
                  "slide-roll: slides or rolls off (mu, alpha); grip: tangential restitution (and ex); "
                  "grip-offset: normal force ahead of the centre (and d, u0); ode: contact mechanics (mu, "
                  "stiffness_ratio, damping_ratio, offset_share, u0, alpha, dwell where it is not measured)")
      ->check(CLI::IsMember({"slide-roll", "grip", "grip-offset", "ode"}))
      ->capture_default_str();
  command
      .add_option("--free", a.free,
                  "Parameters to fit, e.g. mu,ex,d,u0,alpha [all of the model, alpha only of ode]")
      ->delimiter(',');
  command
      .add_option(
          "--fix", a.fix,
          "name=value of parameters that are not fitted, e.g. mu=0.55,d=3; d in mm, u0 in m/s, dwell in ms")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option("--weights", a.weights,
                  "equal: 1 m/s of vx counts like 1 m/s of R omega; sd: by each observation's sd; auto: sd "
                  "for the shots of "
                  "a FILE if each has them, else equal")
      ->check(CLI::IsMember({"auto", "equal", "sd"}))
      ->capture_default_str();
  command
      .add_option("--covariance", a.covariance,
                  "What sd and interval are made from: clustered (residuals, however they scatter and "
                  "however alike shots of "
                  "one condition are), residuals (taken as alike and independent: times chi2/dof), or stated "
                  "(the weights "
                  "alone)")
      ->check(CLI::IsMember({"clustered", "residuals", "stated"}))
      ->capture_default_str();
  command.add_option("--diameter-m", a.diameter_m, "Diameter of the ball, m")->capture_default_str();
}

void add_ode_options(CLI::App& command, Arguments& a) {
  a.of_ode.push_back(
      command
          .add_option(
              "--sampler", a.sampler,
              "ode: how intervals are found: importance (draws from the Laplace approximation, weighted), "
              "metropolis (adaptive), laplace (unchecked), or auto: importance, where that fails "
              "metropolis")
          ->check(CLI::IsMember({"auto", "importance", "metropolis", "laplace"}))
          ->capture_default_str());
  a.of_ode.push_back(command
                         .add_option("--draws", a.draws,
                                     "ode: draws of the sampler [8000 for a few shots, 1500 for hundreds]")
                         ->check(CLI::Range(200, 1000000)));
  a.of_ode.push_back(command.add_option("--seed", a.seed, "ode: of the draws")->capture_default_str());
  a.of_ode.push_back(
      command
          .add_option(
              "--gravity-mps2", a.gravity_mps2,
              "ode: component of gravity towards the surface, m/s^2: 9.81 times the cosine of the plate's "
              "inclination; 0 leaves it out")
          ->check(CLI::Range(0.0, 100.0))
          ->capture_default_str());
}

void add_data_options(CLI::App& command, Arguments& a) {
  command.add_option("FILE", a.files, "results.csv of sessions [the 21 conditions of the thesis]");
  command
      .add_option("--spread", a.spread,
                  "Which sd of the conditions: of one shot (replicate), as printed, or of the mean")
      ->check(CLI::IsMember({"replicate", "mean"}))
      ->capture_default_str();
  command.add_option("--spin", a.spin, "Only these: zero, top or back")
      ->check(CLI::IsMember({"zero", "top", "back"}));
  command.add_flag("--as-printed", a.as_printed, "The conditions without their corrections");
  command
      .add_option("--leave-out", a.leave_one_group_out,
                  "Fit without each spin or condition in turn and predict it: spin, condition or none")
      ->check(CLI::IsMember({"spin", "condition", "none"}))
      ->capture_default_str();
}

}  // namespace

void add_fit_command(CLI::App& app, int& exit_status) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("fit", "Fit friction and restitution to measured rebounds.");
  add_data_options(*command, *arguments);
  add_model_options(*command, *arguments);
  add_ode_options(*command, *arguments);
  command->add_flag("--json", arguments->json,
                    "JSON objects on stdout: fit, observations, then those left out");
  command_line::for_experts(*command, {"--weights", "--covariance", "--spread", "--as-printed", "--leave-out",
                                       "--diameter-m", "--sampler", "--draws", "--seed", "--gravity-mps2"});
  command->footer(
      "Example: strobe fit --model grip-offset --leave-out spin\n"
      "         strobe fit session/results.csv --free mu,ex --fix d=3 --weights sd --json\n"
      "         strobe fit session/results.csv --model ode");
  command->callback([arguments, &exit_status] { exit_status = run_fit(*arguments); });
}

}  // namespace strobe::host
