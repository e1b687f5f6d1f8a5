// The legacy estimator on a digitized frame.
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/reduction/legacy.hpp"
#include "common/reduction/observations.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

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
