#include "common/geometry/leg_classification.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/geometry/leg.hpp"

namespace strobe::geometry {
namespace {

/// A true airborne image passes a three-sigma test but once in 740.
constexpr double kSigmas = 3.0;

/// A leg's lower edge as its images have it, and when it is at the surface.
struct Prediction {
  LegFit path;
  double crossing_s = 0.0;
};

class TimedClassifier {
 public:
  TimedClassifier(std::span<const TimedHeight> images, double gravity)
      : images_(images), gravity_(gravity), legs_(images.size()) {}

  LegAssignment classify() {
    for (std::size_t i = 0; i < images_.size(); ++i) legs_[i] = images_[i].leg;
    assign_safe();
    extend(Leg::incoming);
    extend(Leg::rebound);
    LegAssignment found;
    for (const auto& leg : legs_) found.legs.push_back(leg.value_or(Leg::contact));
    drop_overlaps(Leg::incoming, found);
    drop_overlaps(Leg::rebound, found);
    return found;
  }

 private:
  double sd(std::size_t i) const {
    return std::sqrt(images_[i].variance_m2 + images_[i].reference_variance_m2);
  }

  /// First and last image of the impact: what is labelled contact, else the lowest image.
  std::pair<std::size_t, std::size_t> impact() const {
    std::optional<std::pair<std::size_t, std::size_t>> labelled;
    std::size_t lowest = 0;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (images_[i].height_m < images_[lowest].height_m) lowest = i;
      if (images_[i].leg == Leg::contact) labelled = {labelled ? labelled->first : i, i};
    }
    return labelled.value_or(std::pair{lowest, lowest});
  }

  /// Assigns the images that are clearly above the surface.
  void assign_safe() {
    const auto [first, last] = impact();
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (legs_[i] || images_[i].height_m <= kSigmas * sd(i)) continue;
      if (i < first) legs_[i] = Leg::incoming;
      if (i > last) legs_[i] = Leg::rebound;
    }
  }

  std::vector<std::size_t> of(Leg leg) const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      if (legs_[i] == leg) indices.push_back(i);
    }
    return indices;
  }

  std::optional<Prediction> predict(std::span<const std::size_t> indices, Leg leg) const {
    Prediction p{LegFit({0.0, gravity_})};
    for (const std::size_t i : indices)
      p.path.add(images_[i].time_s, {0.0, images_[i].height_m}, 1.0 / images_[i].variance_m2);
    const std::size_t nearest = leg == Leg::incoming ? indices.back() : indices.front();
    const auto at = crossing(p.path, 0.0, images_[nearest].time_s);
    if (!at || (at->velocity.y() < 0.0) != (leg == Leg::incoming)) return std::nullopt;
    p.crossing_s = at->time_s;
    return p;
  }

  /// Beneath touching by more than what is not known of the path at the image's time: of a slow leg that
  /// grows fast with the time from its other images.
  bool beneath(const Prediction& p, std::size_t i) const {
    const double time_s = images_[i].time_s;
    const double height_m = p.path.path().position_at(time_s - p.path.mean_time_s()).y();
    const double variance = p.path.position_variance(time_s) + images_[i].reference_variance_m2;
    return height_m < -kSigmas * std::sqrt(variance);
  }

  /// Clearly below touching, whatever the leg's path says: it is predicted without the air.
  bool pressed(std::size_t i) const { return images_[i].height_m < -kSigmas * sd(i); }

  static bool airborne(double time_s, double crossing_s, Leg leg) {
    return leg == Leg::incoming ? time_s < crossing_s : time_s > crossing_s;
  }

  /// Adds unlabelled images next to the leg, one by one, as long as they are before its touchdown.
  void extend(Leg leg) {
    for (;;) {
      const std::vector<std::size_t> indices = of(leg);
      if (indices.empty()) return;
      const bool incoming = leg == Leg::incoming;
      // wraps below 0: beyond size
      const std::size_t next = incoming ? indices.back() + 1 : indices.front() - 1;
      if (next >= images_.size() || legs_[next]) return;
      const auto path = predict(indices, leg);
      const bool above =
          path ? airborne(images_[next].time_s, path->crossing_s, leg) : images_[next].height_m > 0.0;
      if (!above || pressed(next)) return;
      legs_[next] = leg;
    }
  }

  /// Leaves out images next to the impact that come after the touchdown which the others predict.
  void drop_overlaps(Leg leg, LegAssignment& found) {
    for (;;) {
      std::vector<std::size_t> others = of(leg);
      if (others.size() < 2) return;
      const std::size_t nearest = leg == Leg::incoming ? others.back() : others.front();
      others.erase(leg == Leg::incoming ? others.end() - 1 : others.begin());
      const auto path = predict(others, leg);
      const bool overlaps = path ? beneath(*path, nearest) : pressed(nearest);
      if (!overlaps || images_[nearest].height_m >= 0.0) return;
      legs_[nearest] = found.legs[nearest] = Leg::contact;
      if (images_[nearest].leg == leg) found.overlaps.push_back(nearest);
    }
  }

  std::span<const TimedHeight> images_;
  double gravity_;
  std::vector<std::optional<Leg>> legs_;
};

double distance_to_line(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const Eigen::Vector2d d = p - a;
  const double length = along.norm();
  if (length <= 0.0) return d.norm();
  return std::abs(d.x() * along.y() - d.y() * along.x()) / length;
}

/// Whether the lowest image, if it does not touch, comes before the impact: it lies on its own leg's line.
bool lowest_is_incoming(std::span<const Eigen::Vector2d> centres, std::size_t lowest) {
  const bool two_before = lowest >= 2;
  const bool two_after = lowest + 2 < centres.size();
  if (two_before != two_after) return two_before;
  if (!two_before) return lowest > 0 || centres.size() == 1;
  return distance_to_line(centres[lowest], centres[lowest - 1], centres[lowest - 2]) <=
         distance_to_line(centres[lowest], centres[lowest + 1], centres[lowest + 2]);
}

}  // namespace

LegAssignment classify_timed(std::span<const TimedHeight> images, double gravity_y_mps2) {
  assert(std::is_sorted(images.begin(), images.end(),
                        [](const TimedHeight& a, const TimedHeight& b) { return a.time_s < b.time_s; }));
  return TimedClassifier(images, gravity_y_mps2).classify();
}

std::vector<Leg> classify_untimed(std::span<const Eigen::Vector2d> centres,
                                  std::span<const std::optional<Leg>> labels, double contact_height) {
  assert(centres.size() == labels.size());
  std::vector<Leg> legs;
  if (centres.empty()) return legs;
  const auto lower = [](const auto& a, const auto& b) { return a.y() < b.y(); };
  const auto lowest =
      static_cast<std::size_t>(std::min_element(centres.begin(), centres.end(), lower) - centres.begin());
  const std::size_t rebound = lowest + (lowest_is_incoming(centres, lowest) ? 1 : 0);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Leg by_order = i < rebound ? Leg::incoming : Leg::rebound;
    legs.push_back(centres[i].y() < contact_height ? Leg::contact : labels[i].value_or(by_order));
  }
  const auto first_contact = std::find_if(legs.begin(), legs.end(), [](Leg l) { return l != Leg::incoming; });
  const auto last_contact = std::find_if(legs.rbegin(), legs.rend(), [](Leg l) { return l != Leg::rebound; });
  if (first_contact < last_contact.base()) std::fill(first_contact, last_contact.base(), Leg::contact);
  return legs;
}

}  // namespace strobe::geometry
