#include "common/reduction/legs.hpp"

#include <cmath>
#include <span>
#include <utility>

namespace strobe::reduction {
namespace {

/// A true airborne image passes a three-sigma test but once in 740.
constexpr double kSigmas = 3.0;

struct Crossing {
  double time_s = 0.0;
  double sd_s = 0.0;
};

/// When a leg's lower edge is at the surface: a straight line in height less the fall, weighted by the noise.
std::optional<Crossing> crossing(std::span<const Height> leg, double gravity, double reference_variance,
                                 bool incoming) {
  if (leg.size() < 2) return std::nullopt;
  double sw = 0.0;
  double st = 0.0;
  for (const Height& h : leg) {
    sw += 1.0 / h.variance_m2;
    st += h.time_s / h.variance_m2;
  }
  const double mean_time = st / sw;
  double sy = 0.0;
  double stt = 0.0;
  double sty = 0.0;
  for (const Height& h : leg) {
    const double t = h.time_s - mean_time;
    const double y = h.height_m - 0.5 * gravity * t * t;
    sy += y / h.variance_m2;
    stt += t * t / h.variance_m2;
    sty += t * y / h.variance_m2;
  }
  const double height = sy / sw;
  const double slope = sty / stt;
  const double square = slope * slope - 2.0 * gravity * height;
  const bool approaches = incoming ? slope < 0.0 : slope > 0.0;
  if (!approaches || !(square > 0.0)) return std::nullopt;
  const double speed = std::copysign(std::sqrt(square), slope);
  const double t = -2.0 * height / (slope + speed);
  const double variance = 1.0 / sw + t * t / stt + reference_variance;
  return Crossing{mean_time + t, std::sqrt(variance) / std::abs(speed)};
}

/// The images in order of time (incoming) or against it (rebound), so that both legs end at the surface.
class Finder {
 public:
  Finder(const std::vector<Height>& images, double gravity, double reference_variance)
      : images_(images), gravity_(gravity), reference_variance_(reference_variance), legs_(images.size()) {}

  LegAssignment find() {
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
  double sd(std::size_t i) const { return std::sqrt(images_[i].variance_m2 + reference_variance_); }

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

  std::optional<Crossing> predict(std::span<const std::size_t> indices, Leg leg) const {
    std::vector<Height> heights;
    for (const std::size_t i : indices) heights.push_back(images_[i]);
    return crossing(heights, gravity_, reference_variance_, leg == Leg::incoming);
  }

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
      const auto cross = predict(indices, leg);
      const bool above =
          cross ? airborne(images_[next].time_s, cross->time_s, leg) : images_[next].height_m > 0.0;
      if (!above) return;
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
      const auto cross = predict(others, leg);
      const double sign = leg == Leg::incoming ? 1.0 : -1.0;
      const bool overlaps = cross ? sign * (images_[nearest].time_s - cross->time_s) > kSigmas * cross->sd_s
                                  : images_[nearest].height_m < -kSigmas * sd(nearest);
      if (!overlaps || images_[nearest].height_m >= 0.0) return;
      legs_[nearest] = found.legs[nearest] = Leg::contact;
      if (images_[nearest].leg == leg) found.overlaps.push_back(nearest);
    }
  }

  const std::vector<Height>& images_;
  double gravity_;
  double reference_variance_;
  std::vector<std::optional<Leg>> legs_;
};

}  // namespace

LegAssignment classify_legs(const std::vector<Height>& images, double gravity_y_mps2,
                            double reference_variance_m2) {
  return Finder(images, gravity_y_mps2, reference_variance_m2).find();
}

}  // namespace strobe::reduction
