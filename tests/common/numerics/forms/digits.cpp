#include "tests/common/numerics/forms/digits.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/common/numerics/forms/forms.hpp"

namespace strobe::numerics {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Ends, their neighbours inwards, a grid in between.
std::vector<double> log_grid(double low, double high, const std::vector<double>& special) {
  std::vector<double> values{low, std::nextafter(low, kInfinity), std::nextafter(high, 0.0), high};
  const int steps = std::clamp(static_cast<int>(std::log10(high / low)), 4, 24);
  for (int i = 1; i < steps; ++i)
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / steps));
  for (const double x : special) {
    values.push_back(x);
    for (const double next : {std::nextafter(x, kInfinity), std::nextafter(x, -kInfinity)})
      if (next >= low && next <= high) values.push_back(next);
  }
  return values;
}

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double log_uniform(Random& random, double low, double high) {
  return std::clamp(std::exp(uniform(random, std::log(low), std::log(high))), low, high);
}

std::string described(const Form& form, const std::vector<double>& arguments) {
  std::string text;
  char number[40];
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    std::snprintf(number, sizeof number, "%.17g", arguments[i]);
    text += (i == 0 ? "" : ", ") + form.axes[i].name + " " + number;
  }
  return text;
}

}  // namespace

Axis logarithmic(std::string name, double low, double high, std::vector<double> special) {
  return {std::move(name), log_grid(low, high, special),
          [low, high](Random& random) { return log_uniform(random, low, high); }};
}

Axis either_sign(std::string name, double least, double most, std::vector<double> special) {
  std::vector<double> values = log_grid(least, most, {});
  const std::size_t positive = values.size();
  for (std::size_t i = 0; i < positive; ++i) values.push_back(-values[i]);
  values.insert(values.end(), special.begin(), special.end());
  values.push_back(0.0);
  return {std::move(name), std::move(values), [least, most](Random& random) {
            const double size = log_uniform(random, least, most);
            const double sign = uniform(random, -1.0, 1.0);
            return std::abs(sign) < 0.02 ? 0.0 : std::copysign(size, sign);
          }};
}

Axis even(std::string name, double low, double high, std::vector<double> special) {
  std::vector<double> values{low, std::nextafter(low, high), std::nextafter(high, low), high};
  for (int i = 1; i < 8; ++i) values.push_back(low + (high - low) * i / 8.0);
  values.insert(values.end(), special.begin(), special.end());
  return {std::move(name), std::move(values),
          [low, high](Random& random) { return uniform(random, low, high); }};
}

Axis unit_interval(std::string name, double low) {
  std::vector<double> values{low, 0.25, 0.5, 0.75, 0.865, 1.0, std::nextafter(1.0, 0.0)};
  for (const double x : {0.25, 0.5}) {
    values.push_back(std::nextafter(x, 0.0));
    values.push_back(std::nextafter(x, 1.0));
  }
  for (int power = -15; power < 0; ++power) {
    const double small = std::pow(10.0, power);
    if (small > low) values.push_back(small);
    values.push_back(1.0 - small);
  }
  return {std::move(name), std::move(values), [low](Random& random) {
            const double kind = uniform(random, 0.0, 1.0);
            if (kind < 0.5) return uniform(random, low, 1.0);
            const double small = log_uniform(random, std::max(low, 1e-16), 1.0);
            return kind < 0.75 ? small : std::clamp(1.0 - small, low, 1.0);
          }};
}

void Tally::record(const std::string& output, double error, double ulps,
                   std::optional<double> textbook_error) {
  Worst& worst = (*worst_)[output];
  ++worst.samples;
  if (!(error <= worst.error)) {
    worst.error = std::isnan(error) ? kInfinity : error;
    worst.argument = argument_;
  }
  worst.ulps = std::max(worst.ulps, ulps);
  if (!textbook_error) return;
  const double textbook = std::isnan(*textbook_error) ? kInfinity : *textbook_error;
  if (worst.textbook_error && !(textbook > *worst.textbook_error)) return;
  worst.textbook_error = textbook;
  worst.textbook_argument = argument_;
}

std::vector<Form> all_forms() {
  std::vector<Form> forms;
  for (const auto group :
       {unit_forms, impact_forms, pulse_forms, flight_forms, reduction_forms, contact_forms})
    for (Form& form : group()) forms.push_back(std::move(form));
  return forms;
}

std::vector<Measured> measure(const Form& form, std::size_t samples, std::uint64_t seed) {
  Random random(seed);
  std::map<std::string, Worst> worst;
  const auto try_one = [&](const std::vector<double>& arguments) {
    Tally tally(described(form, arguments));
    tally.use(worst);
    form.evaluate(arguments, tally);
  };
  const std::size_t half = std::max<std::size_t>(samples / 2, 1);
  std::vector<double> arguments(form.axes.size());
  for (std::size_t i = 0; i < half; ++i) {
    // Every value of every argument in turn (the first ones along with it at random), so that all are met.
    for (std::size_t k = 0; k < arguments.size(); ++k) {
      const auto& values = form.axes[k].structured;
      arguments[k] =
          values[k == i % arguments.size() ? i / arguments.size() % values.size() : random() % values.size()];
    }
    try_one(arguments);
  }
  for (std::size_t i = 0; i < half; ++i) {
    for (std::size_t k = 0; k < arguments.size(); ++k) arguments[k] = form.axes[k].draw(random);
    try_one(arguments);
  }
  std::vector<Measured> rows;
  for (const auto& [output, w] : worst)
    rows.push_back({form.name, output, form.scale, form.rewritten, form.tolerance, w});
  return rows;
}

}  // namespace strobe::numerics
