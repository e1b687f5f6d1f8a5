#include "common/messages/lcm_conversions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <tuple>
#include <utility>

#include "common/messages/record.hpp"

namespace strobe::messages {
namespace {

using reduction::Quantities;
using reduction::Quantity;
using reduction::Readout;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

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
  for (const auto& [quantity, field] : kValueFields) m.*field = quantities[quantity].value_or(kNotANumber);
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

namespace {

using reduction::BallImage;
using reduction::Frame;
using reduction::Leg;
using reduction::PointPx;
using strobe_msgs::ball_image_t;
using strobe_msgs::frame_t;

constexpr std::int32_t kMaxImages = 512;
constexpr std::int32_t kMaxSurfacePoints = 10000;

bool finite(double x, double y) { return std::isfinite(x) && std::isfinite(y); }

/// A number that is above 0 (or at least 0), or NaN for unknown.
std::optional<Error> take(double value, const std::string& field, std::optional<double>& into,
                          bool zero_too = false) {
  if (std::isnan(value)) return std::nullopt;
  if (!std::isfinite(value) || !(value > 0.0 || (zero_too && value == 0.0)))
    return Error{field + ": must be positive, or NaN for unknown"};
  into = value;
  return std::nullopt;
}

Result<std::optional<Leg>> leg_from(std::int8_t leg, const std::string& field) {
  if (leg == ball_image_t::LEG_UNKNOWN) return std::optional<Leg>();
  if (leg == ball_image_t::LEG_INCOMING) return std::optional(Leg::incoming);
  if (leg == ball_image_t::LEG_CONTACT) return std::optional(Leg::contact);
  if (leg == ball_image_t::LEG_REBOUND) return std::optional(Leg::rebound);
  return fail(field + ": unknown leg " + std::to_string(leg));
}

std::int8_t leg_to(std::optional<Leg> leg) {
  constexpr std::array kLegs{ball_image_t::LEG_INCOMING, ball_image_t::LEG_CONTACT,
                             ball_image_t::LEG_REBOUND};
  return leg ? kLegs[static_cast<std::size_t>(*leg)] : ball_image_t::LEG_UNKNOWN;
}

std::int8_t source_to(const std::string& source, const std::string& of_frame) {
  if (source == of_frame) return ball_image_t::SOURCE_OF_FRAME;
  if (source == "auto") return ball_image_t::SOURCE_AUTO;
  if (source == "hand") return ball_image_t::SOURCE_HAND;
  return ball_image_t::SOURCE_OF_FRAME;
}

Result<std::string> source_from(std::int8_t source, const std::string& of_frame, const std::string& field) {
  if (source == ball_image_t::SOURCE_OF_FRAME) return of_frame;
  if (source == ball_image_t::SOURCE_AUTO) return std::string("auto");
  if (source == ball_image_t::SOURCE_HAND) return std::string("hand");
  return fail(field + ": unknown source " + std::to_string(source));
}

/// The source of most images, the earlier one's of equals.
std::string source_of(const Frame& frame) {
  std::map<std::string, int> counts;
  for (const BallImage& image : frame.images) ++counts[image.source];
  std::string source;
  int most = 0;
  for (const BallImage& image : frame.images) {
    if (counts[image.source] > most) most = counts[image.source], source = image.source;
  }
  return source;
}

/// The centre's covariance, all of it or nothing.
std::optional<Error> covariance_from(const ball_image_t& m, const std::string& place, BallImage& image) {
  const double xx = m.centre_xx_px2, xy = m.centre_xy_px2, yy = m.centre_yy_px2;
  if (std::isnan(xx) && std::isnan(xy) && std::isnan(yy)) return std::nullopt;
  const bool definite = std::isfinite(xx) && std::isfinite(xy) && std::isfinite(yy) && xx > 0.0 && yy > 0.0 &&
                        std::abs(xy) < std::sqrt(xx) * std::sqrt(yy);
  if (!definite) return Error{place + "centre_xx_px2, xy, yy: must be positive definite, or NaN for unknown"};
  image.centre_cov_px2 = {xx, xy, xy, yy};
  return std::nullopt;
}

std::optional<Error> diameter_from(const ball_image_t& m, const std::string& place, BallImage& image) {
  const bool optional = image.leg == Leg::contact;
  if (optional && std::isnan(m.diameter_px)) return std::nullopt;
  if (!std::isfinite(m.diameter_px) || !(m.diameter_px > 0.0))
    return Error{place + "diameter_px: must be positive"};
  image.diameter_px = m.diameter_px;
  return std::nullopt;
}

/// The drawn line's angles, their sds and correlation.
std::optional<Error> line_from(const ball_image_t& m, const std::string& place, BallImage& image) {
  const std::tuple<double, const char*, std::optional<double>&> angles[] = {
      {m.equator_rad, "equator_rad", image.equator_rad},
      {m.equator_tilt_rad, "equator_tilt_rad", image.equator_tilt_rad},
      {m.equator_tilt_correlation, "equator_tilt_correlation", image.equator_tilt_correlation}};
  for (const auto& [value, field, into] : angles) {
    if (std::isinf(value)) return Error{place + field + ": must be finite, or NaN for not seen"};
    if (!std::isnan(value)) into = value;
  }
  std::optional<Error> error = take(m.equator_sd_rad, place + "equator_sd_rad", image.equator_sd_rad);
  if (!error) error = take(m.equator_tilt_sd_rad, place + "equator_tilt_sd_rad", image.equator_tilt_sd_rad);
  return error;
}

Result<BallImage> image_from(const ball_image_t& m, const std::string& place, const std::string& source) {
  BallImage image;
  auto leg = leg_from(m.leg, place + "leg");
  if (!leg) return tl::unexpected(leg.error());
  image.leg = *leg;
  auto measured_by = source_from(m.source, source, place + "source");
  if (!measured_by) return tl::unexpected(measured_by.error());
  image.source = std::move(*measured_by);
  if (!finite(m.centre_x_px, m.centre_y_px)) return fail(place + "centre_px: must be two finite numbers");
  image.centre_px = {m.centre_x_px, m.centre_y_px};
  if (finite(m.top_x_px, m.top_y_px)) image.top_px = PointPx{m.top_x_px, m.top_y_px};
  std::optional<Error> error = diameter_from(m, place, image);
  if (!error) error = covariance_from(m, place, image);
  if (!error) error = line_from(m, place, image);
  if (!error) error = take(m.diameter_sd_px, place + "diameter_sd_px", image.diameter_sd_px);
  if (!error) error = take(m.contact_width_px, place + "contact_width_px", image.contact_width_px);
  if (!error) error = take(m.probability, place + "probability", image.probability);
  if (error) return tl::unexpected(*error);
  return image;
}

std::optional<Error> noise_from(const frame_t& m, Frame& frame) {
  std::optional<Error> error = take(m.centre_sd_px, "centre_sd_px", frame.centre_sd_px);
  if (!error) error = take(m.diameter_sd_px, "diameter_sd_px", frame.diameter_sd_px);
  if (!error) error = take(m.surface_sd_px, "surface_sd_px", frame.surface_sd_px);
  if (!error) error = take(m.equator_sd_rad, "equator_sd_rad", frame.equator_sd_rad);
  if (!error) error = take(m.px_per_m, "px_per_m", frame.px_per_m);
  if (!error) error = take(m.px_per_m_sd, "px_per_m_sd", frame.px_per_m_sd, true);
  if (!error)
    error = take(m.shared_diameter_sd_px, "shared_diameter_sd_px", frame.shared_diameter_sd_px, true);
  return error;
}

std::optional<Error> counts_from(const frame_t& m) {
  const bool counts_fit = m.surface.size() == static_cast<std::size_t>(std::max(m.surface_count, 0)) &&
                          m.images.size() == static_cast<std::size_t>(std::max(m.image_count, 0));
  if (!counts_fit) return Error{"surface_count, image_count: do not fit the arrays"};
  if (m.surface_count == 1 || m.surface_count > kMaxSurfacePoints)
    return Error{"surface: needs at least two points, or none"};
  if (m.image_count > kMaxImages) return Error{"images: at most 512 are allowed"};
  return std::nullopt;
}

ball_image_t image_to(const BallImage& image, const std::string& source) {
  ball_image_t m;
  m.leg = leg_to(image.leg);
  m.source = source_to(image.source, source);
  m.centre_x_px = image.centre_px.x;
  m.centre_y_px = image.centre_px.y;
  const auto& c = image.centre_cov_px2;
  m.centre_xx_px2 = c ? (*c)[0] : kNotANumber;
  m.centre_xy_px2 = c ? 0.5 * ((*c)[1] + (*c)[2]) : kNotANumber;
  m.centre_yy_px2 = c ? (*c)[3] : kNotANumber;
  m.diameter_px = image.leg == Leg::contact && !(image.diameter_px > 0.0) ? kNotANumber : image.diameter_px;
  m.diameter_sd_px = image.diameter_sd_px.value_or(kNotANumber);
  m.equator_rad = image.equator_rad.value_or(kNotANumber);
  m.equator_sd_rad = image.equator_sd_rad.value_or(kNotANumber);
  m.equator_tilt_rad = image.equator_tilt_rad.value_or(kNotANumber);
  m.equator_tilt_sd_rad = image.equator_tilt_sd_rad.value_or(kNotANumber);
  m.equator_tilt_correlation = image.equator_tilt_correlation.value_or(kNotANumber);
  m.top_x_px = image.top_px ? image.top_px->x : kNotANumber;
  m.top_y_px = image.top_px ? image.top_px->y : kNotANumber;
  m.contact_width_px = image.contact_width_px.value_or(kNotANumber);
  m.probability = image.probability.value_or(kNotANumber);
  return m;
}

}  // namespace

Result<Frame> frame_from_lcm(const frame_t& m) {
  if (m.schema_version != frame_t::SCHEMA_VERSION) {
    return fail("schema_version: is " + std::to_string(m.schema_version) + ", known is " +
                std::to_string(frame_t::SCHEMA_VERSION));
  }
  if (auto error = counts_from(m)) return tl::unexpected(*error);
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

frame_t frame_to_lcm(const Frame& frame) {
  frame_t m;
  m.schema_version = frame_t::SCHEMA_VERSION;
  m.boot_id = 0;
  m.host_id = 0;
  m.shot_id = frame.shot_id;
  m.source = source_of(frame);
  m.centre_sd_px = frame.centre_sd_px.value_or(kNotANumber);
  m.diameter_sd_px = frame.diameter_sd_px.value_or(kNotANumber);
  m.surface_sd_px = frame.surface_sd_px.value_or(kNotANumber);
  m.equator_sd_rad = frame.equator_sd_rad.value_or(kNotANumber);
  m.px_per_m = frame.px_per_m.value_or(kNotANumber);
  m.px_per_m_sd = frame.px_per_m_sd.value_or(kNotANumber);
  m.surface_count = static_cast<std::int32_t>(frame.surface_px.size());
  for (const PointPx& p : frame.surface_px) {
    strobe_msgs::point_t point;
    point.x_px = p.x;
    point.y_px = p.y;
    m.surface.push_back(point);
  }
  // A message has no place for images of other legs.
  for (const BallImage& image : frame.images)
    if (!image.other_leg) m.images.push_back(image_to(image, m.source));
  m.image_count = static_cast<std::int32_t>(m.images.size());
  m.shared_diameter_sd_px = frame.shared_diameter_sd_px.value_or(kNotANumber);
  return m;
}

}  // namespace strobe::messages
