#include "host/commands/reduce/reduce_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/units/angles.hpp"

namespace strobe::host {

namespace {

using frontier::Row;
using reduction::Quantity;

constexpr std::string_view kFineStudy = "reduce_fine";
constexpr std::array<std::string_view, 3> kStudies{"reduce", "reduce_estimated", kFineStudy};

/// Between the two noises that were measured: their geometric mean.
constexpr double kFineBelow_mm = 0.1;

bool all_stated(const reduction::Frame& frame) {
  const auto stated = [&](const reduction::BallImage& image) {
    return (frame.centre_sd_px || image.centre_cov_px2) && (frame.diameter_sd_px || image.diameter_sd_px) &&
           (frame.equator_sd_rad || image.equator_sd_rad || !image.equator_rad);
  };
  return (frame.surface_sd_px || frame.centre_sd_px) && std::ranges::all_of(frame.images, stated);
}

double px_per_m(const reduction::Frame& frame) {
  if (frame.px_per_m) return *frame.px_per_m;
  double sum = 0.0;
  for (const reduction::BallImage& image : frame.images) sum += image.diameter_px;
  return sum / static_cast<double>(frame.images.size()) / frame.ball_diameter_m;
}

/// Of a coordinate, rms over the images; absent if one has none.
std::optional<double> centre_sd_mm(const reduction::Frame& frame) {
  double sum_px2 = 0.0;
  for (const reduction::BallImage& image : frame.images) {
    if (image.centre_cov_px2)
      sum_px2 += 0.5 * ((*image.centre_cov_px2)[0] + (*image.centre_cov_px2)[3]);
    else if (frame.centre_sd_px)
      sum_px2 += *frame.centre_sd_px * *frame.centre_sd_px;
    else
      return std::nullopt;
  }
  return 1e3 * std::sqrt(sum_px2 / static_cast<double>(frame.images.size())) / px_per_m(frame);
}

std::optional<flight::Effects> effects_from(std::string_view text) {
  flight::Effects effects = flight::kNoEffects;
  if (text == "none") return effects;
  if (text == "all") return flight::Effects{};
  while (!text.empty()) {
    const auto end = text.find('+');
    const std::string_view word = text.substr(0, end);
    const auto known = std::ranges::find(flight::kEffectNames, word);
    if (known == flight::kEffectNames.end()) return std::nullopt;
    effects.*flight::kEffectMembers[static_cast<std::size_t>(known - flight::kEffectNames.begin())] = true;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return effects;
}

/// Subtracts the smallest error in squares: all rows were measured on the same photographs.
void subtract_best_error(std::vector<Row>& rows) {
  double least = std::numeric_limits<double>::infinity();
  for (const Row& row : rows) least = std::min(least, row.error);
  for (Row& row : rows) row.error = std::sqrt((row.error - least) * (row.error + least));
}

/// On photographs with little noise an excess error is mostly bias, which noise hides but does not remove.
void raise_to_fine_error(std::vector<Row>& rows, const std::vector<Row>& fine) {
  for (Row& row : rows) {
    for (const Row& other : fine) {
      if (other.method == row.method && other.parameter == row.parameter)
        row.error = std::max(row.error, other.error);
    }
  }
}

/// The rows of a study that reduce() can run, with their excess errors.
std::vector<Row> excess_errors(const std::vector<Row>& rows, std::string_view study) {
  std::vector<Row> own = frontier::of_study(rows, study);
  std::erase_if(own, [](const Row& row) { return !estimator_for(row); });
  subtract_best_error(own);
  return own;
}

bool is_allowed(const Row& row, const EstimatorRequirement& requirement) {
  if (!requirement.estimator.empty() && row.method != requirement.estimator) return false;
  return requirement.flight.empty() ||
         frontier::parameter_value(row.parameter, "effects") == requirement.flight;
}

double scale_of(Quantity quantity, const reduction::Readout& readout, double speed_mps, double radius_m) {
  switch (quantity) {
    case Quantity::omega_td_radps:
    case Quantity::omega_lo_radps:
      return speed_mps / radius_m;
    case Quantity::theta_in_deg:
    case Quantity::theta_out_deg:
      return degrees(1.0);
    case Quantity::e:
    case Quantity::mu:
      return 1.0;
    case Quantity::dwell_time_ms:
      return readout.value[Quantity::dwell_time_ms].value_or(0.0);
    case Quantity::dwell_distance_cm:
      return speed_mps * readout.value[Quantity::dwell_time_ms].value_or(0.0) * 1e-1;
    case Quantity::court_pace:  // not among the numbers measured: it follows from e and mu
      return 0.0;
    default:
      return speed_mps;
  }
}

double images_per_leg(const reduction::Frame& frame) {
  return 0.5 * static_cast<double>(std::ranges::count_if(
                   frame.images, [](const auto& image) { return image.leg != reduction::Leg::contact; }));
}

}  // namespace

std::optional<MeasuredEstimator> estimator_for(const Row& row) {
  const auto estimator = reduction::estimator_from_name(row.method);
  if (!estimator || frontier::parameter_value(row.parameter, "covariance") == "yes") return std::nullopt;
  MeasuredEstimator measured{.estimator = *estimator, .options = {}};
  if (*estimator != reduction::Estimator::best) return measured;
  const auto effects = frontier::parameter_value(row.parameter, "effects");
  if (!effects) return std::nullopt;
  if (*effects == "auto") return measured;
  measured.options.effects = effects_from(*effects);
  return measured.options.effects ? std::optional(measured) : std::nullopt;
}

std::string study_for(const reduction::Frame& frame) {
  if (!all_stated(frame)) return "reduce_estimated";
  return centre_sd_mm(frame).value_or(1.0) < kFineBelow_mm ? std::string(kFineStudy) : "reduce";
}

std::optional<LargestSd> largest_sd(const reduction::Readout& readout, double ball_diameter_m) {
  const auto speed_mps = readout.value[Quantity::v_td_mps];
  if (!speed_mps) return std::nullopt;
  std::optional<LargestSd> largest;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<Quantity>(i);
    const auto sd = readout.sd[quantity];
    const double scale = scale_of(quantity, readout, *speed_mps, 0.5 * ball_diameter_m);
    if (!sd || !(scale > 0.0)) continue;
    if (!largest || *sd / scale > largest->share) largest = {quantity, *sd / scale};
  }
  return largest;
}

Result<EstimatorChooser> EstimatorChooser::make(const std::vector<Row>& rows,
                                                std::vector<frontier::Range> ranges,
                                                EstimatorRequirement requirement, HostTime (*now)()) {
  EstimatorChooser chooser;
  chooser.ranges_ = std::move(ranges);
  chooser.now_ = now;
  const std::vector<Row> fine = excess_errors(rows, kFineStudy);
  for (const std::string_view study : kStudies) {
    std::vector<Row> kind = excess_errors(rows, study);
    if (kind.empty()) continue;
    raise_to_fine_error(kind, fine);
    std::erase_if(kind, [&](const Row& row) { return !is_allowed(row, requirement); });
    const auto chosen = frontier::choose(kind, requirement.requirement);
    chooser.kinds_.push_back({std::string(study), std::move(kind), chosen});
  }
  chooser.requirement_ = std::move(requirement);
  if (std::ranges::any_of(chooser.kinds_, [](const Kind& kind) { return kind.chosen.has_value(); }))
    return chooser;
  return fail(frontier::failure_text(
      chooser.kinds_.empty() ? frontier::NearestMethods{} : chooser.kinds_[0].chosen.error(),
      chooser.requirement_.requirement));
}

const EstimatorChooser::Kind* EstimatorChooser::kind_of(const reduction::Frame& frame) const {
  const auto named = [this](std::string_view study) {
    const auto kind = std::ranges::find(kinds_, study, &Kind::study);
    return kind == kinds_.end() ? nullptr : &*kind;
  };
  const Kind* kind = frame.images.empty() ? nullptr : named(study_for(frame));
  if (kind == nullptr) kind = named("reduce");
  return kind != nullptr ? kind : &kinds_.front();
}

/// The cost has a part per image and a constant part: more images than were measured cost at most in
/// proportion.
EstimatorChooser::Kind EstimatorChooser::with_costs_of(Kind kind, const reduction::Frame& frame) const {
  for (const frontier::Range& range : ranges_) {
    if (range.study != kind.study || range.quantity != "images_per_leg") continue;
    const double times = images_per_leg(frame) / range.highest;
    if (!(times > 1.0) || !std::isfinite(times)) continue;
    for (Row& row : kind.rows) row.cost_us *= times;
    kind.chosen = frontier::choose(kind.rows, requirement_.requirement);
  }
  return kind;
}

Result<reduction::Readout> EstimatorChooser::timed(const Row& row, const reduction::Frame& frame,
                                                   EstimatorChoice& choice) const {
  const MeasuredEstimator with = *estimator_for(row);
  const HostTime begin = now_();
  auto readout = reduction::reduce(frame, with.estimator, with.options);
  choice.duration += now_() - begin;
  choice.expected_cost_us += row.cost_us;
  if (!readout) return readout;
  choice.row = row;
  choice.noise = largest_sd(*readout, frame.ball_diameter_m);
  choice.noise_beyond_tolerance = requirement_.requirement.tolerance && choice.noise &&
                                  choice.noise->share > *requirement_.requirement.tolerance;
  return readout;
}

/// A less accurate estimator has a larger sd: the most accurate one in the time left may do better.
std::optional<Row> EstimatorChooser::better(const Kind& kind, const EstimatorChoice& choice) const {
  frontier::Requirement rest;
  if (requirement_.requirement.deadline_us)
    rest.deadline_us = *requirement_.requirement.deadline_us - choice.expected_cost_us;
  const auto most_exact = frontier::choose(kind.rows, rest);
  if (!most_exact || most_exact->error >= choice.row.error || most_exact->method == choice.row.method)
    return std::nullopt;
  return *most_exact;
}

Result<ChosenReadout> EstimatorChooser::reduce(const reduction::Frame& frame) const {
  const Kind kind = with_costs_of(*kind_of(frame), frame);
  if (!kind.chosen) return fail(frontier::failure_text(kind.chosen.error(), requirement_.requirement));
  ChosenReadout result;
  EstimatorChoice& choice = result.choice;
  auto readout = timed(*kind.chosen, frame, choice);
  if (!readout) return tl::unexpected(readout.error());
  choice.reason = frontier::reason(kind.rows, requirement_.requirement);
  if (choice.noise_beyond_tolerance) {
    if (const auto row = better(kind, choice)) {
      const auto first = choice.row;
      if (auto instead = timed(*row, frame, choice)) {
        choice.replaced = first;
        readout = std::move(instead);
      }
    }
  }
  const std::array quantities{
      frontier::Quantity{"v_td_mps", readout->value[Quantity::v_td_mps].value_or(std::nan(""))},
      frontier::Quantity{"centre_sd_mm", centre_sd_mm(frame).value_or(std::nan(""))},
      frontier::Quantity{"images_per_leg", images_per_leg(frame)}};
  for (const frontier::Quantity& quantity : quantities) {
    if (!std::isnan(quantity.value))
      for (std::string& name : frontier::outside(ranges_, kind.study, std::array{quantity}))
        choice.outside.push_back(std::move(name));
  }
  result.readout = std::move(*readout);
  return result;
}

}  // namespace strobe::host
