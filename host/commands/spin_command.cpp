// strobe spin: attitudes of a ball with a known pattern of dots, and the spin vector that joins them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/attitude/attitude_spin.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/config/digitize_times.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"

namespace strobe::host {
namespace {

using Eigen::Vector3d;
using nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;

struct SpinOptions {
  std::vector<std::string> images;
  std::string pattern;
  std::string times_file;  ///< empty: none
  bool times_from_names = false;
  std::vector<double> circle;  ///< column, row, diameter; empty: found
  double fastest_spin_radps = 1000.0;
  double pattern_sd_deg = 1.0;
  bool constant = false;
  bool json = false;
};

struct MeasuredImage {
  std::string file;
  std::optional<double> time_s;
  Result<digitize::BallAttitude> attitude;
};

/// "686338211101.png" is at 686.338211101 s.
Result<double> time_from_name(const std::string& file) {
  const std::string stem = std::filesystem::path(file).stem().string();
  std::int64_t ns = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), ns);
  if (error != std::errc{} || end != stem.data() + stem.size() || ns < 0)
    return fail(file + ": --times-from-names: the name is no number of nanoseconds");
  return static_cast<double>(ns) * 1e-9;
}

/// One for each image; none if none are given.
Result<std::vector<double>> times_of(const SpinOptions& options) {
  std::vector<double> times_s;
  if (options.times_from_names) {
    for (const std::string& file : options.images) {
      const auto time = time_from_name(file);
      if (!time) return tl::unexpected(time.error());
      times_s.push_back(*time);
    }
  } else if (!options.times_file.empty()) {
    const auto text = read_option_file("--times", options.times_file);
    if (!text) return tl::unexpected(text.error());
    const auto lines = parse_flash_times(*text, options.times_file);
    if (!lines) return tl::unexpected(lines.error());
    if (lines->size() != 1 || lines->front().size() != options.images.size())
      return fail(fmt::format("{}: must be one line of {} times, one for each image", options.times_file,
                              options.images.size()));
    times_s = lines->front();
  }
  return times_s;
}

Result<digitize::BallAttitude> measured(const std::string& file, const digitize::DotPattern& pattern,
                                        const SpinOptions& options) {
  const auto photograph = digitize::load_photograph(file);
  if (!photograph) return tl::unexpected(photograph.error());
  const auto map = digitize::PlaneMap::uncalibrated(photograph->height());
  digitize::Outline outline;
  if (options.circle.empty()) {
    const auto found = digitize::only_ball(*photograph);
    if (!found) return tl::unexpected(found.error());
    outline = *found;
  } else {
    outline.centre = map.to_plane({options.circle[0], options.circle[1]});
    outline.diameter = options.circle[2];
    outline.covariance = cv::Matx33d::eye();  // by a person: a pixel
    outline.blur_px = 1.0;
  }
  return digitize::measure_attitude(*photograph, map, outline, pattern, options.pattern_sd_deg * kDegree);
}

ordered_json vector_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json matrix_json(const Eigen::Matrix3d& m) {
  return {vector_json(m.row(0)), vector_json(m.row(1)), vector_json(m.row(2))};
}

Vector3d sds(const Eigen::Matrix3d& covariance) { return covariance.diagonal().cwiseSqrt(); }

double rate_sd(const attitude::SpinFit& fit) {
  const Vector3d axis = fit.spin_radps.normalized();
  return std::sqrt(axis.dot(fit.covariance_radps2 * axis));
}

/// Of its two directions together.
double axis_sd_rad(const attitude::SpinFit& fit) {
  const double across = fit.covariance_radps2.trace() - std::pow(rate_sd(fit), 2.0);
  return std::sqrt(std::max(0.0, across)) / fit.spin_radps.norm();
}

double rms_residual_rad(const attitude::SpinFit& fit) {
  double sum = 0.0, n = 0.0;
  for (std::size_t k = 0; k < fit.used.size(); ++k)
    if (fit.used[k]) sum += fit.residuals_rad[k].squaredNorm(), n += 1.0;
  return std::sqrt(sum / n);
}

class SpinReport {
 public:
  SpinReport(const SpinOptions& options, std::vector<MeasuredImage> images)
      : options_(options), images_(std::move(images)) {}

  int run() {
    bool timed = true;
    std::vector<attitude::TimedAttitude> attitudes;
    for (std::size_t k = 0; k < images_.size(); ++k) {
      timed = timed && images_[k].time_s;
      if (!images_[k].attitude) continue;
      attitudes.push_back({images_[k].time_s.value_or(0.0), images_[k].attitude->attitude,
                           images_[k].attitude->covariance_rad2});
      of_.push_back(k);
    }
    // Air takes some tenths of a spin a second; moments of inertia of a ball differ by some thousandths.
    attitude::SpinSearch search{options_.fastest_spin_radps, 0.5, 0.01};
    if (options_.constant) search.decay_sd_per_s = search.wobble_sd = 0.0;
    if (timed && images_.size() > 1) fits_ = attitude::fit_spin(attitudes, search);
    if (options_.json)
      std::printf("%s\n", messages::json_text(json()).c_str());
    else
      print_text();
    if (fits_ && !*fits_) failed("spin: " + fits_->error().message);
    return attitudes.size() < images_.size() || (fits_ && (!*fits_ || (*fits_)->size() > 1)) ? kFailed
                                                                                             : kDone;
  }

 private:
  ordered_json json() const {
    ordered_json out{{"attitudes", ordered_json::array()}, {"spins", ordered_json::array()}};
    for (const MeasuredImage& image : images_) {
      ordered_json one{{"photograph", image.file}};
      if (image.time_s) one["time_s"] = *image.time_s;
      if (const auto& found = image.attitude) {
        one["rotation_rad"] = vector_json(attitude::rotation_vector_rad(found->attitude));
        one["covariance_rad2"] = matrix_json(found->covariance_rad2);
        one["dots_seen"] = found->seen;
        one["dots_matched"] = found->matched;
        one["rms_rad"] = found->rms_rad;
      } else {
        one["error"] = image.attitude.error().message;
      }
      out["attitudes"].push_back(std::move(one));
    }
    if (fits_ && *fits_)
      for (const attitude::SpinFit& fit : **fits_) out["spins"].push_back(spin_json(fit));
    return out;
  }

  ordered_json spin_json(const attitude::SpinFit& fit) const {
    ordered_json outliers = ordered_json::array();
    for (std::size_t k = 0; k < fit.used.size(); ++k)
      if (!fit.used[k]) outliers.push_back(images_[of_[k]].file);
    return {{"spin_radps", vector_json(fit.spin_radps)},
            {"covariance_radps2", matrix_json(fit.covariance_radps2)},
            {"rate_radps", fit.spin_radps.norm()},
            {"rate_sd_radps", rate_sd(fit)},
            {"axis_sd_rad", axis_sd_rad(fit)},
            {"time_s", fit.reference_time_s},
            {"decay_per_s", fit.decay_per_s},
            {"decay_sd_per_s", fit.decay_sd_per_s},
            {"wobble_radps", vector_json(fit.wobble_radps)},
            {"wobble_sd_radps", vector_json(sds(fit.wobble_covariance_radps2))},
            {"chi_squared", fit.chi_squared},
            {"degrees_of_freedom", fit.degrees_of_freedom},
            {"rms_residual_rad", rms_residual_rad(fit)},
            {"outliers", std::move(outliers)}};
  }

  void print_text() const {
    fmt::print("   time ms     rotation x, y, z deg            sd deg           dots\n");
    for (const MeasuredImage& image : images_) {
      const std::string time =
          image.time_s ? fmt::format("{:10.3f}", 1e3 * (*image.time_s - images_.front().time_s.value()))
                       : fmt::format("{:>10}", "-");
      if (!image.attitude) {
        fmt::print("{}  {}\n", time, image.attitude.error().message);
        continue;
      }
      const Vector3d turn = attitude::rotation_vector_rad(image.attitude->attitude) / kDegree;
      const Vector3d sd = sds(image.attitude->covariance_rad2) / kDegree;
      fmt::print("{}  {:8.2f} {:8.2f} {:8.2f}   {:5.2f} {:5.2f} {:5.2f}   {} of {} dark spots\n", time,
                 turn.x(), turn.y(), turn.z(), sd.x(), sd.y(), sd.z(), image.attitude->matched,
                 image.attitude->seen);
    }
    if (!fits_ || !*fits_) return;
    for (const attitude::SpinFit& fit : **fits_) print_spin(fit);
    if ((*fits_)->size() > 1)
      fmt::print("{} spins explain these images: the first is the likeliest, of equals the slowest\n",
                 (*fits_)->size());
  }

  void print_spin(const attitude::SpinFit& fit) const {
    const Vector3d& s = fit.spin_radps;
    const Vector3d sd = sds(fit.covariance_radps2);
    fmt::print(
        "spin {:.2f} ± {:.2f} rad/s: x {:.2f} ± {:.2f}, y {:.2f} ± {:.2f}, z {:.2f} ± {:.2f}; axis ± {:.2f} "
        "deg\n",
        s.norm(), rate_sd(fit), s.x(), sd.x(), s.y(), sd.y(), s.z(), sd.z(), axis_sd_rad(fit) / kDegree);
    fmt::print("  attitudes {:.2f} deg rms about it, chi squared {:.1f} for {} degrees of freedom\n",
               rms_residual_rad(fit) / kDegree, fit.chi_squared, fit.degrees_of_freedom);
    if (!options_.constant)
      fmt::print("  it loses {:.3f} ± {:.3f} of itself per s, and wobbles by {:.2f} ± {:.2f} rad/s\n",
                 fit.decay_per_s, fit.decay_sd_per_s, fit.wobble_radps.norm(),
                 std::sqrt(fit.wobble_covariance_radps2.trace() / 2.0));
    for (std::size_t k = 0; k < fit.used.size(); ++k)
      if (!fit.used[k])
        fmt::print("  left out: {}, {:.1f} deg off\n", images_[of_[k]].file,
                   fit.residuals_rad[k].norm() / kDegree);
  }

  const SpinOptions& options_;
  std::vector<MeasuredImage> images_;
  std::vector<std::size_t> of_;  ///< image of each attitude
  std::optional<Result<std::vector<attitude::SpinFit>>> fits_;
};

int run_spin(const SpinOptions& options) {
  const auto text = read_option_file("--pattern", options.pattern);
  if (!text) return bad_input(text.error().message);
  const auto pattern = digitize::parse_dot_pattern(*text, options.pattern);
  if (!pattern) return bad_input(pattern.error().message);
  const auto times_s = times_of(options);
  if (!times_s) return bad_input(times_s.error().message);
  std::vector<MeasuredImage> images;
  bool any = false;
  for (std::size_t k = 0; k < options.images.size(); ++k) {
    images.push_back({options.images[k], {}, measured(options.images[k], *pattern, options)});
    if (!times_s->empty()) images.back().time_s = (*times_s)[k];
    any = any || images.back().attitude;
  }
  if (!any) return bad_input(images.front().attitude.error().message);
  return SpinReport(options, std::move(images)).run();
}

}  // namespace

void add_spin_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<SpinOptions>();
  CLI::App* command =
      app.add_subcommand("spin", "Attitudes and spin vector of a ball with a pattern of dots");
  command->add_option("IMAGE", options->images, "photographs or cut-outs with one ball each: TIFF, PNG, JPEG")
      ->required();
  command->option_defaults()->always_capture_default();
  command
      ->add_option("--pattern", options->pattern,
                   "the dots: a CSV of x,y,z (directions) or theta,phi (degrees), a dot a row")
      ->required();
  auto* times = command->add_option("--times", options->times_file,
                                    "when the images were taken: one JSON array of seconds");
  command
      ->add_flag("--times-from-names", options->times_from_names,
                 "each file's name is its time in nanoseconds")
      ->excludes(times);
  command
      ->add_option("--circle", options->circle,
                   "the ball's outline, where it cannot be found: column, row, diameter [px]")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(0.0, 1e5));
  command
      ->add_option("--fastest-spin", options->fastest_spin_radps,
                   "whole turns are considered up to this [rad/s]")
      ->check(CLI::Range(1.0, 1e5));
  command
      ->add_option("--pattern-sd-deg", options->pattern_sd_deg,
                   "how well the dots are where the pattern says")
      ->check(CLI::Range(0.01, 10.0));
  command->add_flag("--constant-spin", options->constant,
                    "no loss of spin to air and no wobble of an uneven ball");
  command->add_flag("--json", options->json, "one JSON object: attitudes, and spins, the likeliest first");
  command->footer(
      "Example: strobe spin crops/*.png --pattern dots.csv --times-from-names\n"
      "Axes: x right, y up, z towards the lens. A rotation takes the pattern's axes to the picture's.\n"
      "Exit status: 1 if an image's attitude is not known, or several spins are as likely.");
  command->callback([options, &exit_status] { exit_status = run_spin(*options); });
}

}  // namespace strobe::host
