// strobe contact: the images in contact against the damped sine pulse and cubic fits.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/contact/analysis.hpp"
#include "common/data/thesis_data.hpp"
#include "host/commands/command.hpp"
#include "host/share.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

struct ContactOptions {
  std::string set;
  std::optional<double> vx_td_mps;
  std::optional<double> vy_td_mps;
  std::optional<double> e;
  std::optional<double> mu;
  std::optional<double> dwell_time_ms;
  std::optional<double> dwell_distance_cm;
  double diameter_m = ball::kThesisDiameter_m;
  std::string form = "exact";
  bool as_printed = false;
  bool json = false;
};

struct Job {
  contact::ContactSet set;
  contact::Inputs inputs;
  double dwell_time_ms = 0.0;
  double dwell_distance_cm = 0.0;
  bool project_set = false;
};

/// Defaults that a project's set brings with it; none for a file.
struct Source {
  contact::ContactSet set;
  std::optional<thesis::Condition> means;
};

Result<contact::ContactSet> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(path.string() + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return fail(path.string() + ": cannot be read");
  return contact::parse_contact_csv(text, path.string());
}

Result<Source> find_source(const ContactOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(options.set, ignored)) {
    if (options.as_printed)
      return fail(options.set + ": --as-printed is for the project's own sets; a file is read as it stands");
    auto set = read_file(options.set);
    if (!set) return tl::unexpected(set.error());
    return Source{*std::move(set), std::nullopt};
  }
  const auto share = share_folder();
  if (!share) return tl::unexpected(share.error());
  const auto version = options.as_printed ? thesis::Version::as_printed : thesis::Version::corrected;
  auto data = thesis::load(*share / "thesis", version);
  if (!data) return tl::unexpected(data.error());
  const thesis::Condition* means = data->condition(options.set);
  if (!means)
    return fail(options.set + ": neither a file nor one of the project's sets (zero_17 to back_68)");
  return Source{data->contact.at(options.set), *means};
}

/// The option's value, else the mean of the project's set.
Result<double> value_or_mean(const std::optional<double>& given, const char* option, const Source& source,
                             thesis::MeanSd thesis::Condition::*mean) {
  if (given) return *given;
  if (source.means) return ((*source.means).*mean).mean;
  return fail(std::string("contact: ") + option + " is needed with a file");
}

Result<Job> prepare(const ContactOptions& o) {
  using thesis::Condition;
  auto source = find_source(o);
  if (!source) return tl::unexpected(source.error());
  const auto vx = value_or_mean(o.vx_td_mps, "--vx-td", *source, &Condition::vx_td_mps);
  const auto vy = value_or_mean(o.vy_td_mps, "--vy-td", *source, &Condition::vy_td_mps);
  const auto e = value_or_mean(o.e, "--e", *source, &Condition::e);
  const auto mu = value_or_mean(o.mu, "--mu", *source, &Condition::mu);
  const auto time = value_or_mean(o.dwell_time_ms, "--dwell-time-ms", *source, &Condition::dwell_time_ms);
  const auto distance =
      value_or_mean(o.dwell_distance_cm, "--dwell-distance-cm", *source, &Condition::dwell_distance_cm);
  for (const auto* value : {&vx, &vy, &e, &mu, &time, &distance})
    if (!*value) return tl::unexpected(value->error());
  Job job{
      .set = std::move(source->set), .inputs = {}, .dwell_time_ms = *time, .dwell_distance_cm = *distance};
  job.project_set = source->means.has_value();
  job.inputs = {.vx_td_mps = *vx,
                .vy_td_mps = *vy,
                .e = *e,
                .mu = *mu,
                .dwell_time_s = *time / 1e3,
                .dwell_distance_m = *distance / 1e2,
                .diameter_m = o.diameter_m,
                .form = o.form == "simplified" ? impact::PulseForm::simplified : impact::PulseForm::exact};
  return job;
}

ordered_json poly(const std::optional<contact::CubicFit>& fit) {
  return fit ? ordered_json(fit->coefficients) : ordered_json();
}

ordered_json poly_errors(const std::optional<contact::CubicFit>& fit) {
  return fit && fit->standard_errors ? ordered_json(*fit->standard_errors) : ordered_json();
}

ordered_json r_squared(const std::optional<contact::CubicFit>& fit) {
  return fit && fit->r_squared ? ordered_json(*fit->r_squared) : ordered_json();
}

void print_json(const Job& job, const ContactOptions& o, const contact::Estimate& estimate,
                const contact::FractionFits& fits) {
  const contact::Inputs& in = job.inputs;
  ordered_json out{
      {"see_x_m", estimate.see_x_m},         {"see_y_m", estimate.see_y_m}, {"n", estimate.n},
      {"damping_f", estimate.damping_f},     {"x_poly", poly(fits.x)},      {"y_poly", poly(fits.y)},
      {"rotation_poly", poly(fits.rotation)}};
  out["r2"] = {{"x", r_squared(fits.x)}, {"y", r_squared(fits.y)}, {"rotation", r_squared(fits.rotation)}};
  out["poly_se"] = {
      {"x", poly_errors(fits.x)}, {"y", poly_errors(fits.y)}, {"rotation", poly_errors(fits.rotation)}};
  out["inputs"] = {{"set", o.set},
                   {"corrected", job.project_set && !o.as_printed},
                   {"vx_td_mps", in.vx_td_mps},
                   {"vy_td_mps", in.vy_td_mps},
                   {"e", in.e},
                   {"mu", in.mu},
                   {"dwell_time_ms", job.dwell_time_ms},
                   {"dwell_distance_cm", job.dwell_distance_cm},
                   {"diameter_m", in.diameter_m},
                   {"form", o.form}};
  std::printf("%s\n", out.dump(-1, ' ', false, ordered_json::error_handler_t::replace).c_str());
}

void print_fit(const char* name, const std::optional<contact::CubicFit>& fit) {
  if (!fit) {
    std::printf("  %-9s too few different times\n", name);
    return;
  }
  const auto& c = fit->coefficients;
  std::printf("  %-9s %9.4f %9.4f %9.4f %9.4f", name, c[0], c[1], c[2], c[3]);
  fit->r_squared ? std::printf("   %.4f", *fit->r_squared) : std::printf("        -");
  std::printf("   %d\n", fit->n);
}

void print_table(const Job& job, const ContactOptions& o, const contact::Estimate& estimate,
                 const contact::FractionFits& fits) {
  const contact::Inputs& in = job.inputs;
  const char* version = !job.project_set ? "" : o.as_printed ? " (as printed)" : " (corrected)";
  std::printf("%s%s: %d images between touchdown and lift-off\n", o.set.c_str(), version, estimate.n);
  std::printf("touchdown vx %g, vy %g m/s; e %g, mu %g; dwell %g ms, %g cm; diameter %g m\n", in.vx_td_mps,
              in.vy_td_mps, in.e, in.mu, job.dwell_time_ms, job.dwell_distance_cm, in.diameter_m);
  std::printf("damped sine pulse, %s form: damping f %.5f\n", o.form.c_str(), estimate.damping_f);
  std::printf("  standard error of estimate: along %.3f mm, normal %.3f mm\n", 1e3 * estimate.see_x_m,
              1e3 * estimate.see_y_m);
  std::printf("cubics in the time fraction        1         T        T2        T3       R2   rows\n");
  print_fit("x", fits.x);
  print_fit("y", fits.y);
  print_fit("rotation", fits.rotation);
}

int run_contact(const ContactOptions& options) {
  const auto job = prepare(options);
  if (!job) return bad_input(job.error().message);
  const auto estimate = contact::estimate_error(job->set, job->inputs);
  if (!estimate) return bad_input(options.set + ": " + estimate.error().message);
  const contact::FractionFits fits = contact::fit_fractions(job->set);
  options.json ? print_json(*job, options, *estimate, fits) : print_table(*job, options, *estimate, fits);
  return kDone;
}

}  // namespace

void add_contact_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ContactOptions>();
  CLI::App* command = app.add_subcommand(
      "contact",
      "Hold the images of a ball in contact against the damped sine pulse, and fit cubics to them.");
  command
      ->add_option(
          "SET", options->set,
          "CSV file with the columns time_fraction,x_fraction,y_fraction,rotation_fraction, read as it "
          "stands; or one of the project's sets (zero_17 to back_68), whose means are the defaults below")
      ->required();
  command->add_option("--vx-td", options->vx_td_mps, "Speed along the surface at touchdown, m/s");
  command->add_option("--vy-td", options->vy_td_mps,
                      "Speed normal to the surface at touchdown, m/s; negative");
  command->add_option("--e", options->e, "Coefficient of restitution, 0 to 1");
  command->add_option("--mu", options->mu,
                      "Impulse ratio; negative where the surface drove the ball forward");
  command->add_option("--dwell-time-ms", options->dwell_time_ms, "Touchdown to lift-off, ms");
  command->add_option("--dwell-distance-cm", options->dwell_distance_cm, "Along the surface, cm");
  command->add_option("--diameter-m", options->diameter_m, "Diameter of the ball, m")->capture_default_str();
  command->add_option("--form", options->form, "Integral of the pulse: exact, or simplified as in the thesis")
      ->check(CLI::IsMember({"exact", "simplified"}))
      ->capture_default_str();
  command->add_flag("--as-printed", options->as_printed, "A project's set without its corrections");
  command->add_flag("--json", options->json, "One JSON object on stdout");
  command->footer(
      "Examples: strobe contact zero_23 --form simplified\n"
      "          strobe contact shot.csv --vx-td 15.62 --vy-td -6.701 --e 0.865 --mu 0.55 "
      "--dwell-time-ms 5.1996 --dwell-distance-cm 6.29 --json");
  command->callback([options, &exit_status] { exit_status = run_contact(*options); });
}

}  // namespace strobe::host
