#include "common/messages/lcm_conversions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <utility>

#include "common/messages/record.hpp"

namespace strobe::messages {
namespace {

using reduction::BallImage;
using reduction::Frame;
using reduction::Leg;
using reduction::PointPx;
using reduction::Quantities;
using reduction::Quantity;
using reduction::Readout;
using reduction::Regime;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::int32_t kMostImages = 512;
constexpr std::int32_t kMostSurfacePoints = 10000;

std::optional<double> optional(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

bool finite(double x, double y) { return std::isfinite(x) && std::isfinite(y); }

Result<std::optional<double>> positive(double value, const std::string& field) {
  if (std::isnan(value)) return std::optional<double>();
  if (!std::isfinite(value) || !(value > 0.0)) return fail(field + ": must be positive, or NaN for unknown");
  return std::optional(value);
}

Result<std::optional<Leg>> leg_from(std::int8_t leg, const std::string& field) {
  using M = strobe_msgs::ball_image_t;
  if (leg == M::LEG_UNKNOWN) return std::optional<Leg>();
  if (leg == M::LEG_INCOMING) return std::optional(Leg::incoming);
  if (leg == M::LEG_CONTACT) return std::optional(Leg::contact);
  if (leg == M::LEG_REBOUND) return std::optional(Leg::rebound);
  return fail(field + ": unknown leg " + std::to_string(leg));
}

std::int8_t leg_to(std::optional<Leg> leg) {
  using M = strobe_msgs::ball_image_t;
  if (!leg) return M::LEG_UNKNOWN;
  switch (*leg) {
    case Leg::incoming:
      return M::LEG_INCOMING;
    case Leg::contact:
      return M::LEG_CONTACT;
    case Leg::rebound:
      return M::LEG_REBOUND;
  }
  return M::LEG_UNKNOWN;
}

Result<BallImage> image_from(const strobe_msgs::ball_image_t& m, const std::string& place,
                             const std::string& source) {
  BallImage image;
  auto leg = leg_from(m.leg, place + "leg");
  if (!leg) return tl::unexpected(leg.error());
  image.leg = *leg;
  if (!finite(m.centre_x_px, m.centre_y_px)) return fail(place + "centre_px: must be two finite numbers");
  if (!std::isfinite(m.diameter_px) || !(m.diameter_px > 0.0))
    return fail(place + "diameter_px: must be positive");
  if (std::isinf(m.equator_rad)) return fail(place + "equator_rad: must be finite, or NaN for not seen");
  image.centre_px = {m.centre_x_px, m.centre_y_px};
  image.diameter_px = m.diameter_px;
  image.equator_rad = optional(m.equator_rad);
  if (finite(m.top_x_px, m.top_y_px)) image.top_px = PointPx{m.top_x_px, m.top_y_px};
  image.source = source;
  return image;
}

std::optional<Error> noise_from(const strobe_msgs::frame_t& m, Frame& frame) {
  struct Field {
    double value;
    const char* name;
    std::optional<double>* into;
  };
  const Field fields[] = {{m.centre_sd_px, "centre_sd_px", &frame.centre_sd_px},
                          {m.diameter_sd_px, "diameter_sd_px", &frame.diameter_sd_px},
                          {m.surface_sd_px, "surface_sd_px", &frame.surface_sd_px},
                          {m.equator_sd_rad, "equator_sd_rad", &frame.equator_sd_rad},
                          {m.px_per_m, "px_per_m", &frame.px_per_m},
                          {m.px_per_m_sd, "px_per_m_sd", &frame.px_per_m_sd}};
  for (const Field& field : fields) {
    auto value = positive(field.value, field.name);
    if (!value) return value.error();
    *field.into = *value;
  }
  return std::nullopt;
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

Result<Frame> frame_from_lcm(const strobe_msgs::frame_t& m) {
  if (m.schema_version != strobe_msgs::frame_t::SCHEMA_VERSION) {
    return fail("schema_version: is " + std::to_string(m.schema_version) + ", known is " +
                std::to_string(strobe_msgs::frame_t::SCHEMA_VERSION));
  }
  const bool counts_fit = m.surface.size() == static_cast<std::size_t>(std::max(m.surface_count, 0)) &&
                          m.images.size() == static_cast<std::size_t>(std::max(m.image_count, 0));
  if (!counts_fit) return fail("surface_count, image_count: do not fit the arrays");
  if (m.surface_count < 2 || m.surface_count > kMostSurfacePoints)
    return fail("surface: needs at least two points");
  if (m.image_count > kMostImages) return fail("images: at most 512 are allowed");
  Frame frame;
  frame.shot_id = m.shot_id;
  if (auto error = noise_from(m, frame)) return tl::unexpected(*error);
  for (std::size_t i = 0; i < m.surface.size(); ++i) {
    const auto& p = m.surface[i];
    if (!finite(p.x_px, p.y_px))
      return fail("surface[" + std::to_string(i) + "]: must be two finite numbers");
    frame.surface_px.push_back({p.x_px, p.y_px});
  }
  for (std::size_t i = 0; i < m.images.size(); ++i) {
    auto image = image_from(m.images[i], "images[" + std::to_string(i) + "].", m.source);
    if (!image) return tl::unexpected(image.error());
    frame.images.push_back(std::move(*image));
  }
  return frame;
}

strobe_msgs::frame_t frame_to_lcm(const Frame& frame) {
  strobe_msgs::frame_t m;
  m.schema_version = strobe_msgs::frame_t::SCHEMA_VERSION;
  m.boot_id = 0;
  m.shot_id = frame.shot_id;
  m.source = frame.images.empty() ? "" : frame.images.front().source;
  m.centre_sd_px = frame.centre_sd_px.value_or(kNone);
  m.diameter_sd_px = frame.diameter_sd_px.value_or(kNone);
  m.surface_sd_px = frame.surface_sd_px.value_or(kNone);
  m.equator_sd_rad = frame.equator_sd_rad.value_or(kNone);
  m.px_per_m = frame.px_per_m.value_or(kNone);
  m.px_per_m_sd = frame.px_per_m_sd.value_or(kNone);
  m.surface_count = static_cast<std::int32_t>(frame.surface_px.size());
  for (const PointPx& p : frame.surface_px) {
    strobe_msgs::point_t point;
    point.x_px = p.x;
    point.y_px = p.y;
    m.surface.push_back(point);
  }
  m.image_count = static_cast<std::int32_t>(frame.images.size());
  for (const BallImage& image : frame.images) {
    strobe_msgs::ball_image_t out;
    out.leg = leg_to(image.leg);
    out.centre_x_px = image.centre_px.x;
    out.centre_y_px = image.centre_px.y;
    out.diameter_px = image.diameter_px;
    out.equator_rad = image.equator_rad.value_or(kNone);
    out.top_x_px = image.top_px ? image.top_px->x : kNone;
    out.top_y_px = image.top_px ? image.top_px->y : kNone;
    m.images.push_back(out);
  }
  return m;
}

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
