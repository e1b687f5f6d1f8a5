#include "tests/hil/truth_score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>

#include "common/reduction/readout.hpp"

namespace strobe::hil {
namespace {

constexpr std::array<const char*, 5> kInvalidatingFlags{
    "shot_aborted", "no_photograph", "flash_match_ambiguous", "too_few_images", "degenerate_geometry"};

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double number_or_nan(const nlohmann::json& object, const std::string& key) {
  if (!object.contains(key) || !object.at(key).is_number()) return std::numeric_limits<double>::quiet_NaN();
  return object.at(key).get<double>();
}

}  // namespace

bool is_rejected(const nlohmann::json& readout) {
  for (const auto& flag : readout.at("flags")) {
    const std::string name = flag.get<std::string>();
    if (std::find(kInvalidatingFlags.begin(), kInvalidatingFlags.end(), name) != kInvalidatingFlags.end())
      return true;
  }
  return false;
}

bool is_complete(const nlohmann::json& readout) {
  for (const std::string_view name : reduction::kQuantityNames)
    if (name != "court_pace" && !readout.at(std::string(name)).is_number()) return false;
  return true;
}

void TruthScore::add(const nlohmann::json& readout, const nlohmann::json& truth, const std::string& name) {
  ++shots_;
  for (const std::string_view view : reduction::kQuantityNames) {
    const std::string quantity(view);
    const double value = number_or_nan(readout, quantity);
    const double expected = number_or_nan(truth.at("readout"), quantity);
    if (std::isnan(value) || std::isnan(expected)) continue;
    const double sd = number_or_nan(readout.at("sd"), quantity);
    const double z = sd > 0.0 ? (value - expected) / sd : std::numeric_limits<double>::infinity();
    errors_[quantity].push_back({z, name});
  }
}

std::optional<double> TruthScore::rms_of(const std::string& quantity) const {
  const auto found = errors_.find(quantity);
  if (found == errors_.end()) return std::nullopt;
  std::vector<double> values;
  for (const Error& error : found->second) values.push_back(error.z);
  return rms(values);
}

std::string TruthScore::beyond(double limit) const {
  std::string lines;
  for (const auto& [quantity, errors] : errors_) {
    for (const Error& error : errors)
      if (std::abs(error.z) > limit)
        lines += fmt::format("\n  {}: {} is off by {:.2f} sd", error.shot, quantity, error.z);
  }
  return lines;
}

std::string TruthScore::implausible_rms(double false_alarm) const {
  std::string lines;
  const double tail = false_alarm / (2.0 * static_cast<double>(errors_.size()));
  for (const auto& [quantity, errors] : errors_) {
    const auto n = static_cast<double>(errors.size());
    const boost::math::chi_squared distribution(n);
    const double low = std::sqrt(boost::math::quantile(distribution, tail) / n);
    const double high = std::sqrt(boost::math::quantile(boost::math::complement(distribution, tail)) / n);
    std::vector<double> values;
    for (const Error& error : errors) values.push_back(error.z);
    const double found = rms(values);
    if (!(found >= low && found <= high)) {
      lines += fmt::format("\n  {}: rms {:.3f} of {} shots, expected {:.3f} to {:.3f}", quantity, found,
                           errors.size(), low, high);
    }
  }
  return lines;
}

std::string TruthScore::table() const {
  std::string lines =
      fmt::format("{:<18} {:>5} {:>7} {:>9}  {}\n", "quantity", "shots", "rms z", "worst z", "of");
  for (const auto& [quantity, errors] : errors_) {
    std::vector<double> values;
    for (const Error& error : errors) values.push_back(error.z);
    const auto worst = std::max_element(errors.begin(), errors.end(), [](const Error& a, const Error& b) {
      return std::abs(a.z) < std::abs(b.z);
    });
    lines += fmt::format("{:<18} {:>5} {:>7.3f} {:>9.2f}  {}\n", quantity, errors.size(), rms(values),
                         worst->z, worst->shot);
  }
  return lines;
}

}  // namespace strobe::hil
