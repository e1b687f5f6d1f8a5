#include "tests/soak/counts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>

namespace strobe::soak {

namespace {

template <std::size_t N>
void add_each(std::array<std::int64_t, N>& sum, const std::array<std::int64_t, N>& more) {
  for (std::size_t i = 0; i < N; ++i) sum[i] += more[i];
}

}  // namespace

void SoakCounts::add(const SoakCounts& other) {
  const auto sum = [&](std::int64_t SoakCounts::*field) { this->*field += other.*field; };
  for (const auto field : {&SoakCounts::runs,
                           &SoakCounts::shots,
                           &SoakCounts::planned,
                           &SoakCounts::unfinished,
                           &SoakCounts::triggers,
                           &SoakCounts::boots,
                           &SoakCounts::hosts,
                           &SoakCounts::good,
                           &SoakCounts::flagged,
                           &SoakCounts::withheld,
                           &SoakCounts::compared,
                           &SoakCounts::explained,
                           &SoakCounts::mismatched,
                           &SoakCounts::packets,
                           &SoakCounts::packets_lost,
                           &SoakCounts::packets_doubled,
                           &SoakCounts::packets_reordered,
                           &SoakCounts::strangers,
                           &SoakCounts::acts,
                           &SoakCounts::stops_reached,
                           &SoakCounts::stops_asked,
                           &SoakCounts::stops_confirmed,
                           &SoakCounts::stops_told_missing,
                           &SoakCounts::stopped_triggers,
                           &SoakCounts::events_journalled,
                           &SoakCounts::events_missing,
                           &SoakCounts::events_never_received,
                           &SoakCounts::events_lost_dying,
                           &SoakCounts::violations})
    sum(field);
  add_each(flags, other.flags);
  add_each(explained_by, other.explained_by);
  add_each(rig_faults, other.rig_faults);
  add_each(hazards, other.hazards);
  for (std::size_t i = 0; i < largest_z.size(); ++i)
    largest_z[i] = std::max(largest_z[i], other.largest_z[i]);
  virtual_s += other.virtual_s;
  digest += other.digest;
}

std::string table_of(const SoakCounts& counts) {
  std::string text;
  const auto line = [&text](std::string_view what, const auto& value) {
    text += fmt::format("{:<44} {:>14}\n", what, value);
  };
  line("runs", counts.runs);
  line("shots fired", counts.shots);
  line("  of runs that wanted", counts.planned);
  line("runs that gave up", counts.unfinished);
  line("hours on the virtual clock", fmt::format("{:.1f}", counts.virtual_s / 3600.0));
  line("starts of the firmware, of hosts", fmt::format("{}, {}", counts.boots, counts.hosts));
  line("pulses of the machine's trigger", counts.triggers);
  line("readouts that count", counts.good);
  line("readouts with numbers that do not count", counts.flagged);
  line("readouts without numbers", counts.withheld);
  line("numbers held against truth", counts.compared);
  line(fmt::format("  beyond {:.2f} sd, explained by a flag", soak_sigma_limit()), counts.explained);
  line("  dwells off by a period, images ambiguous", counts.mismatched);
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    if (counts.flags[i] == 0) continue;
    line(fmt::format("  readouts with {}, off with it", reduction::kFlagNames[i]),
         fmt::format("{}, {}", counts.flags[i], counts.explained_by[i]));
  }
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    line(fmt::format("  largest z unexplained, {}", reduction::kQuantityNames[i]),
         fmt::format("{:.2f}", counts.largest_z[i]));
  for (std::size_t i = 0; i < counts.rig_faults.size(); ++i)
    line(fmt::format("exposures with {}", sim::kFaultNames[i]), counts.rig_faults[i]);
  for (std::size_t i = 0; i < kHazardCount; ++i)
    line(fmt::format("times {}", kHazardNames[i]), counts.hazards[i]);
  line("acts of persons, to fire", counts.acts);
  line("stops that reached the rig", counts.stops_reached);
  line("stops asked for at hosts", counts.stops_asked);
  line("  shown as confirmed", counts.stops_confirmed);
  line("  shown as not confirmed within a second", counts.stops_told_missing);
  line("trigger pulses between a stop and an act", counts.stopped_triggers);
  line("packets, times receivers", counts.packets);
  line("  lost, doubled, reordered",
       fmt::format("{}, {}, {}", counts.packets_lost, counts.packets_doubled, counts.packets_reordered));
  line("  sent by strangers", fmt::format("{}", counts.strangers));
  line("events journalled", counts.events_journalled);
  line("  missing on the hosts in the end", counts.events_missing);
  line("  of boots that ended before a host heard them", counts.events_never_received);
  line("events in the queue of a process that died", counts.events_lost_dying);
  line("violations", counts.violations);
  line("digest", fmt::format("{:016x}", counts.digest));
  return text;
}


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
    case Flag::spin_limit_assumed:
    case Flag::air_extrapolated:
    case Flag::axis_tilted:
    case Flag::out_of_plane:
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
