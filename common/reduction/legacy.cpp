#include "common/reduction/legacy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/geometry/line.hpp"
#include "common/impact/closed_form/rebound.hpp"
#include "common/reduction/observations.hpp"

namespace strobe::reduction {
namespace {

using impact::Motion;

constexpr double kDegrees = 57.3;  // the program's constants
constexpr double kPiLegacy = 3.1416;
constexpr double kHalfPiLegacy = 1.5708;

struct LevelImage {
  double x = 0.0;
  double y = 0.0;
  double slope = 0.0;
  double diameter = 0.0;
};

Eigen::Vector2d position(const PointPx& p) { return {p.x, p.y}; }

LevelImage level_image(const LegacyImage& image, const geometry::Rotation2d& rotation) {
  const Eigen::Vector2d centre = rotation * position(image.centre);
  const Eigen::Vector2d edge = rotation * position(image.edge);
  const Eigen::Vector2d a = rotation * position(image.equator_1);
  const Eigen::Vector2d b = rotation * position(image.equator_2);
  return {centre.x(), centre.y(), (b.y() - a.y()) / (b.x() - a.x()),
          2.0 * std::hypot(edge.x() - centre.x(), edge.y() - centre.y())};
}

/// Change of the equator's angle between two images, by the program's rules.
double equator_rotation_rad(double slope_a, double slope_b) {
  const double difference = std::atan(slope_b) - std::atan(slope_a);
  if (slope_a > 1.0 && slope_b < -1.0) return difference + kPiLegacy;
  if (slope_a < 0.0 && slope_b > 0.0) return difference - kPiLegacy;
  return difference;
}

double speed_mps(const Motion& m) { return std::hypot(m.vx_mps, m.vy_mps); }

Motion between(const LevelImage& a, const LevelImage& b, double m_per_px, double period_s) {
  const double per_second = m_per_px / period_s;
  return {(b.x - a.x) * per_second, (b.y - a.y) * per_second,
          equator_rotation_rad(a.slope, b.slope) / period_s};
}

void put(Quantities& q, Quantity which, double value) {
  if (std::isfinite(value)) q[which] = value;
}

Quantities motions(const Motion& td, const Motion& lo, double radius_m) {
  Quantities q;
  put(q, Quantity::theta_in_deg, std::atan(td.vy_mps / td.vx_mps) * kDegrees);
  put(q, Quantity::theta_out_deg, std::atan(lo.vy_mps / lo.vx_mps) * kDegrees);
  put(q, Quantity::vx_td_mps, td.vx_mps);
  put(q, Quantity::vy_td_mps, td.vy_mps);
  put(q, Quantity::v_td_mps, speed_mps(td));
  put(q, Quantity::omega_td_radps, td.omega_radps);
  put(q, Quantity::vx_lo_mps, lo.vx_mps);
  put(q, Quantity::vy_lo_mps, lo.vy_mps);
  put(q, Quantity::v_lo_mps, speed_mps(lo));
  put(q, Quantity::omega_lo_radps, lo.omega_radps);
  put(q, Quantity::slip_lo_mps, lo.vx_mps + radius_m * lo.omega_radps);
  put(q, Quantity::e, -lo.vy_mps / td.vy_mps);
  put(q, Quantity::mu, (td.vx_mps - lo.vx_mps) / (lo.vy_mps - td.vy_mps));
  return q;
}

/// A frame after the program's preparation: rotated, surface heights, mean diameter.
struct Prepared {
  std::array<LevelImage, 6> flight;
  double surface_td = 0.0;
  double surface_lo = 0.0;
  double diameter = 0.0;
};

Prepared prepare(const LegacyFrame& frame, const geometry::Rotation2d& rotation) {
  Prepared p;
  for (std::size_t i = 0; i < 6; ++i) {
    p.flight[i] = level_image(frame.flight[i], rotation);
    p.diameter += p.flight[i].diameter / 6.0;
  }
  const auto height = [&](std::size_t i) { return (rotation * position(frame.surface[i])).y(); };
  p.surface_td = 0.5 * (height(0) + height(1));
  p.surface_lo = 0.5 * (height(2) + height(3));
  return p;
}

/// Where the straight path through an image reaches a height, and the time along it, which is never negative.
struct PathEnd {
  double x = 0.0;
  double y = 0.0;
  double time_s = 0.0;
};

PathEnd path_end(const LevelImage& from, const Motion& motion, double height, double m_per_px) {
  const double x = from.x + (height - from.y) * motion.vx_mps / motion.vy_mps;
  const double length = std::hypot(x - from.x, height - from.y) * m_per_px;
  return {x, height, length / speed_mps(motion)};
}

struct Impact {
  PathEnd td;
  PathEnd lo;
  double dwell_s = 0.0;
  double angle_td = 0.0;
  double angle_total = 0.0;
};

ContactImage contact_image(const LevelImage& image, const Impact& impact, const Prepared& p, double time_s,
                           double diameter_m) {
  ContactImage out;
  out.height_cm = (image.y - p.surface_td) * 100.0 * diameter_m / p.diameter;
  out.time_fraction = (time_s - impact.td.time_s) / impact.dwell_s;
  out.x_fraction = (image.x - impact.td.x) / (impact.lo.x - impact.td.x);
  out.y_fraction = (image.y + 0.5 * image.diameter - (p.surface_td + p.diameter)) / p.diameter;
  double angle = std::atan(image.slope) - impact.angle_td;
  if (impact.angle_td > kHalfPiLegacy && image.slope < -1.0) {
    angle += kPiLegacy;
  } else if (impact.angle_td < 0.0 && image.slope > 0.0) {
    angle -= kPiLegacy;
  }
  out.rotation_fraction = angle / impact.angle_total;
  return out;
}

Impact impact_of(const LegacyFrame& frame, const Prepared& p, const Motion& td, const Motion& lo,
                 double m_per_px) {
  Impact impact;
  impact.td = path_end(p.flight[2], td, p.surface_td + 0.5 * p.diameter, m_per_px);
  impact.lo = path_end(p.flight[3], lo, p.surface_lo + 0.5 * p.diameter, m_per_px);
  impact.dwell_s = (frame.contact_count + 1) * frame.period_s - impact.td.time_s - impact.lo.time_s;
  impact.angle_td = std::atan(p.flight[2].slope) + td.omega_radps * impact.td.time_s;
  impact.angle_total = std::atan(p.flight[3].slope) - lo.omega_radps * impact.lo.time_s - impact.angle_td;
  if (impact.angle_total > 0.0) impact.angle_total -= kPiLegacy;
  return impact;
}

double median_interval(const Frame& frame) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < frame.images.size(); ++i) {
    intervals.push_back(frame.images[i].time_s - frame.images[i - 1].time_s);
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

/// The points that a person would have digitized for the program. An equator that was not seen has no slope,
/// and the numbers that need it are absent.
LegacyImage points(const BallImage& image, double sign) {
  constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
  const double r = 0.5 * image.diameter_px;
  const double angle = image.equator_rad ? sign * *image.equator_rad : kUnseen;
  const PointPx c{sign * image.centre_px.x, image.centre_px.y};
  const double dx = r * std::cos(angle);
  const double dy = r * std::sin(angle);
  return {c, {c.x + r, c.y}, {c.x - dx, c.y - dy}, {c.x + dx, c.y + dy}};
}

}  // namespace

Readout reduce_legacy(const LegacyFrame& frame, double ball_diameter_m) {
  Readout readout;
  readout.shot_id = frame.frame_number;
  readout.method = "legacy";
  const double angle =
      std::atan2(frame.surface[2].y - frame.surface[0].y, frame.surface[2].x - frame.surface[0].x);
  const geometry::Rotation2d rotation(angle);  // by +a: the program's doubling of the tilt
  const Prepared p = prepare(frame, rotation);
  const double m_per_px = ball_diameter_m / p.diameter;
  const auto& f = p.flight;
  const Motion td = between(f[1], f[2], m_per_px, frame.period_s);
  const Motion lo = between(f[3], f[4], m_per_px, frame.period_s);
  readout.value = motions(td, lo, 0.5 * ball_diameter_m);
  const Impact impact = impact_of(frame, p, td, lo, m_per_px);
  put(readout.value, Quantity::dwell_time_ms, impact.dwell_s * 1e3);
  const double distance = std::hypot(impact.lo.x - impact.td.x, impact.lo.y - impact.td.y) * m_per_px;
  put(readout.value, Quantity::dwell_distance_cm, distance * 1e2);
  readout.legacy.emplace();
  readout.legacy->far = motions(between(f[0], f[1], m_per_px, frame.period_s),
                                between(f[4], f[5], m_per_px, frame.period_s), 0.5 * ball_diameter_m);
  for (std::size_t i = 0; i < frame.contact.size(); ++i) {
    const double time_s = static_cast<double>(i + 1) * frame.period_s;
    readout.legacy->contact.push_back(
        contact_image(level_image(frame.contact[i], rotation), impact, p, time_s, ball_diameter_m));
  }
  if (frame.contact.empty()) readout.flags.set(Flag::no_contact_image);
  return readout;
}

Frame frame_from_legacy(const LegacyFrame& legacy) {
  Frame frame;
  frame.shot_id = legacy.frame_number;
  frame.ball_diameter_m = kLegacyDiameter_m;
  frame.record["frame_number"] = std::to_string(legacy.frame_number);
  frame.surface_px.assign(legacy.surface.begin(), legacy.surface.end());
  const auto add = [&](const LegacyImage& image, int flash, Leg leg) {
    BallImage out;
    out.time_s = flash * legacy.period_s;
    out.flash_index = flash;
    out.leg = leg;
    out.centre_px = image.centre;
    out.diameter_px = 2.0 * std::hypot(image.edge.x - image.centre.x, image.edge.y - image.centre.y);
    const double dx = image.equator_2.x - image.equator_1.x;
    const double dy = image.equator_2.y - image.equator_1.y;
    if (dx != 0.0 || dy != 0.0) out.equator_rad = std::atan2(dy, dx);
    out.source = "hand";
    frame.images.push_back(std::move(out));
  };
  for (int i = 0; i < 3; ++i) add(legacy.flight[static_cast<std::size_t>(i)], i, Leg::incoming);
  for (std::size_t i = 0; i < legacy.contact.size(); ++i)
    add(legacy.contact[i], 3 + static_cast<int>(i), Leg::contact);
  for (int i = 0; i < 3; ++i) {
    add(legacy.flight[static_cast<std::size_t>(3 + i)], 3 + legacy.contact_count + i, Leg::rebound);
  }
  return frame;
}

Result<Readout> reduce_legacy(const Frame& frame) {
  FlagSet flags;
  const std::optional<Observations> all = observe(frame, flags);
  Readout absent;
  absent.shot_id = frame.shot_id;
  absent.method = "legacy";
  absent.record = frame.record;
  absent.flags = flags;
  if (!all) return absent;
  absent.mirrored = all->surface.mirrored;
  const double sign = absent.mirrored ? -1.0 : 1.0;

  std::vector<std::size_t> incoming;
  std::vector<std::size_t> rebound;
  LegacyFrame legacy;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const Leg leg = all->images[i].leg.value_or(Leg::contact);
    if (leg == Leg::incoming) incoming.push_back(i);
    if (leg == Leg::rebound) rebound.push_back(i);
    if (leg == Leg::contact && legacy.contact.size() < 2)
      legacy.contact.push_back(points(frame.images[i], sign));
  }
  if (incoming.size() < 3 || rebound.size() < 3 || frame.surface_px.size() < 4) {
    absent.flags.set(Flag::too_few_images);
    return absent;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    legacy.flight[i] = points(frame.images[incoming[incoming.size() - 3 + i]], sign);
    legacy.flight[3 + i] = points(frame.images[rebound[i]], sign);
  }
  std::vector<PointPx> surface = frame.surface_px;
  for (PointPx& p : surface) p.x *= sign;
  std::stable_sort(surface.begin(), surface.end(),
                   [](const PointPx& a, const PointPx& b) { return a.x < b.x; });
  legacy.surface = {surface[0], surface[1], surface[surface.size() - 2], surface.back()};
  legacy.period_s = median_interval(frame);
  const double gap = frame.images[rebound.front()].time_s - frame.images[incoming.back()].time_s;
  legacy.contact_count = static_cast<int>(std::lround(std::clamp(gap / legacy.period_s, -1e6, 1e6))) - 1;
  if (legacy.contact_count < 0) {  // the legs are labelled in the wrong order
    absent.flags.set(Flag::degenerate_geometry);
    return absent;
  }
  Readout readout = reduce_legacy(legacy, frame.ball_diameter_m);
  readout.shot_id = frame.shot_id;
  readout.record = frame.record;
  readout.mirrored = absent.mirrored;
  readout.flags = flags;
  return readout;
}

}  // namespace strobe::reduction
