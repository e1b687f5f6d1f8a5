#include "common/messages/lcm_conversions.hpp"

#include <limits>
#include <strobe_msgs/readout_t.hpp>
#include <utility>

#include "common/messages/record.hpp"

namespace strobe::messages {
namespace {

using reduction::Quantities;
using reduction::Quantity;
using reduction::Readout;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Both structures list the quantities in the same order; one table ties a message's field to its Quantity.
constexpr std::pair<Quantity, double strobe_msgs::readout_values_t::*> kValueFields[] = {
    {Quantity::theta_in_deg, &strobe_msgs::readout_values_t::theta_in_deg},
    {Quantity::theta_out_deg, &strobe_msgs::readout_values_t::theta_out_deg},
    {Quantity::vx_td_mps, &strobe_msgs::readout_values_t::vx_td_mps},
    {Quantity::vy_td_mps, &strobe_msgs::readout_values_t::vy_td_mps},
    {Quantity::v_td_mps, &strobe_msgs::readout_values_t::v_td_mps},
    {Quantity::omega_td_radps, &strobe_msgs::readout_values_t::omega_td_radps},
    {Quantity::vx_lo_mps, &strobe_msgs::readout_values_t::vx_lo_mps},
    {Quantity::vy_lo_mps, &strobe_msgs::readout_values_t::vy_lo_mps},
    {Quantity::v_lo_mps, &strobe_msgs::readout_values_t::v_lo_mps},
    {Quantity::omega_lo_radps, &strobe_msgs::readout_values_t::omega_lo_radps},
    {Quantity::slip_lo_mps, &strobe_msgs::readout_values_t::slip_lo_mps},
    {Quantity::e, &strobe_msgs::readout_values_t::e},
    {Quantity::mu, &strobe_msgs::readout_values_t::mu},
    {Quantity::dwell_time_ms, &strobe_msgs::readout_values_t::dwell_time_ms},
    {Quantity::dwell_distance_cm, &strobe_msgs::readout_values_t::dwell_distance_cm},
    {Quantity::court_pace, &strobe_msgs::readout_values_t::court_pace},
};
static_assert(std::size(kValueFields) == reduction::kQuantityCount);

strobe_msgs::readout_values_t values_to(const Quantities& quantities) {
  strobe_msgs::readout_values_t m;
  for (const auto& [quantity, field] : kValueFields) m.*field = quantities[quantity].value_or(kNone);
  return m;
}

}  // namespace

strobe_msgs::readout_t readout_to_lcm(const Readout& readout, std::int64_t host_id, std::int64_t boot_id) {
  strobe_msgs::readout_t m;
  m.schema_version = strobe_msgs::readout_t::SCHEMA_VERSION;
  m.host_id = host_id;
  m.boot_id = boot_id;
  m.shot_id = readout.shot_id;
  m.value = values_to(readout.value);
  m.sd = values_to(readout.sd);
  m.sd_systematic = values_to(readout.sd_systematic);
  m.regime = readout.regime ? std::string(name(*readout.regime)) : "";
  m.court_pace_conforming = readout.court_pace_conforming ? 1 : 0;
  m.method = readout.method;
  m.mirrored = readout.mirrored ? 1 : 0;
  for (std::size_t i = 0; i < flight::kEffectNames.size(); ++i) {
    if (readout.flight_effects.*flight::kEffectMembers[i])
      m.flight_effects.emplace_back(flight::kEffectNames[i]);
  }
  m.effect_count = static_cast<std::int32_t>(m.flight_effects.size());
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (readout.flags.has(flag)) m.flags.emplace_back(name(flag));
  }
  m.flag_count = static_cast<std::int32_t>(m.flags.size());
  m.notes = notes_from_record(readout.record);
  m.note_count = static_cast<std::int32_t>(m.notes.size());
  return m;
}

}  // namespace strobe::messages
