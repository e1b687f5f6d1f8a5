#include "tests/soak/truth_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>

namespace strobe::soak {

using reduction::Flag;
using reduction::Quantity;

double sigma_limit(double comparisons, double false_alarms) {
  return std::sqrt(2.0) * boost::math::erfc_inv(false_alarms / comparisons);
}

double soak_sigma_limit() {
  static const double limit = sigma_limit(static_cast<double>(reduction::kQuantityCount) * 1e6, 1e-3);
  return limit;
}

bool explains(Flag flag) {
  switch (flag) {
    case Flag::shot_aborted:
    case Flag::no_photograph:
    case Flag::too_few_images:
    case Flag::late_flash:
    case Flag::missing_flash:
    case Flag::double_flash:
    case Flag::flash_match_ambiguous:
    case Flag::clock_suspect:
    case Flag::degenerate_geometry:
    case Flag::sensor_missing:
    case Flag::events_missing:
    case Flag::spin_aliased:
    case Flag::air_not_fitted:
    case Flag::surface_suspect:
    case Flag::scale_contradicts_ball:
    case Flag::residuals_exceed_noise:
    case Flag::scale_sd_unknown:
      return true;
    case Flag::outlier_image:
    case Flag::outlier_surface_point:
    case Flag::no_redundancy:
    case Flag::no_contact_image:
    case Flag::overlaps_surface:
    case Flag::sd_from_residuals:
    case Flag::shutter_suspect:
    case Flag::flash_index_ambiguous:
      return false;
  }
  return false;
}

namespace {

double z_of(const reduction::Readout& readout, const Truth& truth, Quantity q) {
  const auto& value = readout.value[q];
  const auto& expected = truth.value[q];
  if (!expected) return std::numeric_limits<double>::infinity();
  const double sd = std::hypot(readout.sd[q].value_or(0.0), readout.sd_systematic[q].value_or(0.0));
  const double error = std::abs(*value - *expected);
  if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
  return sd > 0.0 ? error / sd : (error == 0.0 ? 0.0 : std::numeric_limits<double>::infinity());
}

}  // namespace

TruthComparison compare_with_truth(const reduction::Readout& readout, const Truth& truth, double limit) {
  TruthComparison result;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<Quantity>(i);
    if (!readout.value[quantity]) continue;
    ++result.compared;
    const double z = z_of(readout, truth, quantity);
    result.z[i] = z;
    bool explained = false;
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f) {
      if (!readout.flags.has(static_cast<Flag>(f)) || !explains(static_cast<Flag>(f))) continue;
      explained = true;
      if (z > limit) result.by_flag[f] = true;
    }
    if (!explained && !(truth.images_ambiguous && z > limit))
      result.largest_z = std::max(result.largest_z, z);
    if (!(z > limit)) continue;
    const bool of_dwell = quantity == Quantity::dwell_time_ms || quantity == Quantity::dwell_distance_cm;
    if (explained) {
      ++result.explained;
    } else if (of_dwell && truth.images_ambiguous) {
      ++result.mismatched;
    } else {
      result.wrong +=
          fmt::format(" {} = {:.6g}, true {}, {:.1f} sd off;", name(quantity), *readout.value[quantity],
                      truth.value[quantity] ? fmt::format("{:.6g}", *truth.value[quantity]) : "none", z);
    }
  }
  return result;
}

}  // namespace strobe::soak
