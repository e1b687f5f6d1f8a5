#include "common/messages/lcm_conversions.hpp"

#include <algorithm>
#include <cmath>
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

std::optional<double> optional(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

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

Result<Quantities> values_from(const strobe_msgs::readout_values_t& m, const std::string& place) {
  Quantities quantities;
  for (const auto& [quantity, field] : kValueFields) {
    if (std::isinf(m.*field))
      return fail(place + "." + std::string(name(quantity)) + ": must be finite, or NaN for none");
    quantities[quantity] = optional(m.*field);
  }
  return quantities;
}

Result<std::optional<Regime>> regime_from(const std::string& text) {
  if (text.empty()) return std::optional<Regime>();
  for (const Regime regime : {Regime::slides, Regime::grips, Regime::unclear}) {
    if (text == name(regime)) return std::optional(regime);
  }
  return fail("regime: unknown word \"" + text + "\"");
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

Result<Readout> readout_from_lcm(const strobe_msgs::readout_t& m) {
  if (m.schema_version != strobe_msgs::readout_t::SCHEMA_VERSION) {
    return fail("schema_version: is " + std::to_string(m.schema_version) + ", known is " +
                std::to_string(strobe_msgs::readout_t::SCHEMA_VERSION));
  }
  Readout readout;
  readout.shot_id = m.shot_id;
  const auto take = [](const strobe_msgs::readout_values_t& from, const char* place, Quantities& into) {
    auto values = values_from(from, place);
    if (values) into = *values;
    return values ? std::optional<Error>() : std::optional(values.error());
  };
  if (auto error = take(m.value, "value", readout.value)) return tl::unexpected(*error);
  if (auto error = take(m.sd, "sd", readout.sd)) return tl::unexpected(*error);
  if (auto error = take(m.sd_systematic, "sd_systematic", readout.sd_systematic))
    return tl::unexpected(*error);
  auto regime = regime_from(m.regime);
  if (!regime) return tl::unexpected(regime.error());
  readout.regime = *regime;
  readout.court_pace_conforming = m.court_pace_conforming != 0;
  readout.method = m.method;
  readout.mirrored = m.mirrored != 0;
  for (const std::string& text : m.flight_effects) {
    const auto* const name = std::find(flight::kEffectNames.begin(), flight::kEffectNames.end(), text);
    if (name == flight::kEffectNames.end()) return fail("flight_effects: unknown effect \"" + text + "\"");
    readout.flight_effects.*
        flight::kEffectMembers[static_cast<std::size_t>(name - flight::kEffectNames.begin())] = true;
  }
  for (const std::string& text : m.flags) {
    const auto flag = reduction::flag_from_name(text);
    if (!flag) return fail("flags: unknown flag \"" + text + "\"");
    readout.flags.set(*flag);
  }
  auto record = record_from_notes(m.notes);
  if (!record) return tl::unexpected(record.error());
  readout.record = std::move(*record);
  return readout;
}

}  // namespace strobe::messages
