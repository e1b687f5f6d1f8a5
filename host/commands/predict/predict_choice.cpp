#include "host/commands/predict/predict_choice.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "common/units/angles.hpp"

namespace strobe::host {

namespace {

using frontier::Row;

constexpr std::string_view kStudy = "lift_off";

/// A check must be this many times as accurate as the checked method and as the tolerance.
constexpr double kCheckAccuracyFactor = 10.0;

template <typename Number>
std::optional<Number> number(const Row& row, std::string_view name) {
  const auto text = frontier::parameter_value(row.parameter, name);
  Number value{};
  if (!text) return std::nullopt;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc{} || end != text->data() + text->size()) return std::nullopt;
  return value;
}

bool take_grip(const Row& row, PredictInput& in) {
  const auto e_x = number<double>(row, "ex");
  const auto offset_mm = number<double>(row, "offset_mm");
  const bool offset = row.method == "grip_offset";
  if (!e_x || (offset && !offset_mm)) return false;
  in.model = "grip";
  in.e_x = *e_x;
  in.offset_mm = offset ? *offset_mm : 0.0;
  return true;
}

/// The method's own error control holds it to its tolerance on every impact.
bool is_adaptive(const Row& row) { return row.method == "ode" || row.method == "collocation"; }

/// What it may be wrong by on any impact: its tolerance, or what was measured where that is more.
double own_error(const Row& adaptive) {
  return std::max(adaptive.error, number<double>(adaptive, "tolerance").value_or(0.0));
}

bool take_return_mapping(const Row& row, PredictInput& in) {
  const auto steps = number<int>(row, "steps");
  in.model = "return_mapping";
  in.integration.steps = steps.value_or(0);
  return steps.has_value();
}

bool take_ode(const Row& row, PredictInput& in) {
  in.model = "ode";
  if (is_adaptive(row)) {
    const auto tolerance = number<double>(row, "tolerance");
    const bool integrated = row.method == "ode";
    in.integration = {
        .method = integrated ? impact::ContactMethod::dormand_prince : impact::ContactMethod::collocation,
        .tolerance = tolerance.value_or(0.0)};
    return tolerance.has_value();
  }
  const auto steps = number<int>(row, "steps");
  const bool rk4 = row.method == "ode_rk4";
  in.integration = {.method = rk4 ? impact::ContactMethod::rk4 : impact::ContactMethod::semi_implicit_euler,
                    .steps = steps.value_or(0)};
  return steps.has_value();
}

double speed_mps(const PredictInput& in) { return std::hypot(in.touchdown.vx_mps, in.touchdown.vy_mps); }

double difference(const PredictInput& in, const impact::Motion& a, const impact::Motion& b) {
  const double spin_mps = 0.5 * in.diameter_m * (a.omega_radps - b.omega_radps);
  return std::hypot(a.vx_mps - b.vx_mps, a.vy_mps - b.vy_mps, spin_mps) / speed_mps(in);
}

/// The lowest ratio measured is no limit, since spins of both signs were measured and no spin lies between
/// them.
double limited_spin_ratio(const MeasuredModels& measured, double ratio) {
  for (const frontier::Range& range : measured.ranges) {
    if (range.study == kStudy && range.quantity == "spin_ratio") return std::max(ratio, range.lowest);
  }
  return ratio;
}

std::vector<std::string> outside(const MeasuredModels& measured, const PredictInput& in) {
  const impact::ContactCoefficients c = contact_of(in);
  const ball::Ball ball = ball_of(in);
  const std::array quantities{
      frontier::Quantity{"v_td_mps", speed_mps(in)},
      frontier::Quantity{"theta_in_deg",
                         degrees(std::atan2(-in.touchdown.vy_mps, std::abs(in.touchdown.vx_mps)))},
      // To the left is the mirror image, whose spin has the other sign.
      frontier::Quantity{"omega_radps", std::copysign(1.0, in.touchdown.vx_mps) * in.touchdown.omega_radps},
      frontier::Quantity{
          "spin_ratio",
          limited_spin_ratio(measured, std::abs(ball.radius_m() * in.touchdown.omega_radps) / speed_mps(in))},
      frontier::Quantity{"e", c.e}, frontier::Quantity{"mu", c.mu}, frontier::Quantity{"alpha", ball.alpha},
      frontier::Quantity{"diameter_m", ball.diameter_m}, frontier::Quantity{"mass_kg", ball.mass_kg},
      frontier::Quantity{"dwell_time_ms", in.dwell_time_ms},
      frontier::Quantity{"kt_ratio", c.stiffness_ratio}, frontier::Quantity{"ct", c.damping_ratio},
      frontier::Quantity{"offset_footprint", c.offset_share},
      frontier::Quantity{"offset_reference_mps", c.offset_reference_mps},
      frontier::Quantity{"gravity_mps2", c.gravity_mps2}};
  return frontier::outside(measured.ranges, kStudy, quantities);
}

bool same_method(const Row& a, const Row& b) { return a.method == b.method && a.parameter == b.parameter; }

/// Runs and checks the chosen methods, one after another.
class Runs {
 public:
  Runs(const MeasuredModels& measured, std::vector<Row> rows, const frontier::Requirement& requirement,
       const PredictInput& in, HostTime (*now)())
      : rows_(std::move(rows)), integrations_(measured.rows), requirement_(requirement), in_(in), now_(now) {
    std::erase_if(integrations_, [](const Row& row) { return !is_adaptive(row); });
  }

  Result<Prediction> take(const Row& row, ImpactChoice& choice) const {
    choice.taken = {.row = row, .error_estimate = {}, .checked_by = {}};
    return run(row, choice);
  }

  /// Compares with a more accurate run if there is time for one. If that shows an error beyond the tolerance
  /// and may be taken, it replaces the prediction. Returns true if so: it is to be checked in turn.
  bool replaced_after_check(Prediction& prediction, ImpactChoice& choice) const {
    const auto check = check_for(choice);
    if (!check) return false;
    auto checked = run(*check, choice);
    if (!checked) return false;
    choice.taken.checked_by = *check;
    choice.taken.error_estimate =
        difference(in_, prediction.rebound.lift_off, checked->rebound.lift_off) + own_error(*check);
    if (!requirement_.tolerance) return false;
    choice.within_tolerance = *choice.taken.error_estimate <= *requirement_.tolerance;
    if (*choice.within_tolerance || !may_be_taken(*check)) return false;
    choice.replaced.push_back(std::exchange(choice.taken, TriedModel{*check, {}, {}}));
    choice.within_tolerance.reset();
    prediction = std::move(*checked);
    return true;
  }

 private:
  /// The cheapest integration accurate enough for a check, within the time left.
  std::optional<Row> check_for(const ImpactChoice& choice) const {
    const double to_judge =
        std::min(choice.taken.row.error, requirement_.tolerance.value_or(choice.taken.row.error));
    frontier::Requirement requirement{.tolerance = to_judge / kCheckAccuracyFactor, .deadline_us = {}};
    if (requirement_.deadline_us)
      requirement.deadline_us = *requirement_.deadline_us - choice.expected_cost_us;
    const auto check = frontier::choose(integrations_, requirement);
    return check ? std::optional(*check) : std::nullopt;
  }

  bool may_be_taken(const Row& check) const {
    return std::ranges::any_of(rows_, [&](const Row& row) { return same_method(row, check); });
  }

  Result<Prediction> run(const Row& row, ImpactChoice& choice) const {
    const PredictInput with = *input_for(row, in_);
    const HostTime begin = now_();
    const auto first = lift_off_only(with);
    const HostTime middle = now_();
    const auto again = lift_off_only(with);
    choice.duration += middle - begin;
    choice.repeated_duration += now_() - middle;
    choice.expected_cost_us += row.cost_us;
    if (!first || !again) return fail(std::string(impact::message((first ? again : first).error())));
    // What is printed besides is nobody's deadline.
    auto prediction = predict(with);
    if (!prediction) return fail(std::string(impact::message(prediction.error())));
    return std::move(*prediction);
  }

  std::vector<Row> rows_;
  std::vector<Row> integrations_;
  const frontier::Requirement& requirement_;
  const PredictInput& in_;
  HostTime (*now_)();
};

ImpactPromise promise_of(const TriedModel& taken) {
  if (taken.error_estimate) return {*taken.error_estimate, PromiseBasis::check};
  if (is_adaptive(taken.row)) return {own_error(taken.row), PromiseBasis::error_control};
  return {taken.row.error, PromiseBasis::worst_measured};
}

}  // namespace

std::optional<PredictInput> input_for(const Row& row, PredictInput in) {
  bool known = true;
  if (row.method == "rigid") {
    in.model = "rigid";
  } else if (row.method == "grip" || row.method == "grip_offset") {
    known = take_grip(row, in);
  } else if (row.method == "pulse_exact" || row.method == "pulse_simplified") {
    in.model = "pulse";
    in.form = row.method.substr(std::string_view("pulse_").size());
  } else if (row.method == "return_mapping") {
    known = take_return_mapping(row, in);
  } else if (is_adaptive(row) || row.method == "ode_rk4" || row.method == "ode_euler") {
    known = take_ode(row, in);
  } else {
    known = false;
  }
  return known ? std::optional(std::move(in)) : std::nullopt;
}

MeasuredModels measured_models(const std::vector<Row>& rows, const std::vector<frontier::Range>& ranges) {
  MeasuredModels measured{.rows = frontier::of_study(rows, kStudy), .ranges = ranges};
  std::erase_if(measured.rows, [](const Row& row) { return !input_for(row, {}); });
  return measured;
}

Result<ImpactChoice> choose_impact(const MeasuredModels& measured, const frontier::Requirement& requirement,
                                   const std::string& model, PredictInput in, HostTime (*now)()) {
  in.mu = in.mu.value_or(default_mu("ode"));
  in.alpha = in.alpha.value_or(default_alpha("ode"));
  std::vector<Row> rows = measured.rows;
  std::erase_if(rows, [&](const Row& row) { return !model.empty() && input_for(row, in)->model != model; });
  const auto first = frontier::choose(rows, requirement);
  if (!first) return fail(frontier::failure_text(first.error(), requirement));

  ImpactChoice choice;
  choice.reason = frontier::reason(rows, requirement);
  choice.outside = outside(measured, in);
  const Runs runs(measured, std::move(rows), requirement, in, now);
  auto prediction = runs.take(*first, choice);
  if (!prediction) return tl::unexpected(prediction.error());
  while (runs.replaced_after_check(*prediction, choice)) {
  }
  choice.promise = promise_of(choice.taken);
  choice.prediction = std::move(*prediction);
  choice.input = *input_for(choice.taken.row, in);
  return choice;
}

}  // namespace strobe::host
