#include "sim/rig/exposure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/rig/camera.hpp"

namespace strobe::sim {

namespace {

constexpr Duration kBlend = microseconds(500);

struct Flash {
  MonoTime time;
  MonoTime stamp;
  int pulse;
};

std::vector<Flash> flashes_on_film(const Exposure& exposure) {
  std::vector<Flash> flashes;
  flashes.reserve(2 * exposure.pulses.size());
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i) {
    const Pulse& pulse = exposure.pulses[i];
    for (std::size_t k = 0; k < pulse.flashes.size(); ++k) {
      const MonoTime time = pulse.flashes[k];
      const MonoTime stamp = k < pulse.stamps.size() ? pulse.stamps[k] : kNoTime;
      if (time >= exposure.opened && time <= exposure.closed)
        flashes.push_back({time, stamp, static_cast<int>(i)});
    }
  }
  std::ranges::sort(flashes, {}, &Flash::time);
  return flashes;
}

/// Flashes that make one image.
struct Blend {
  MonoTime time;
  MonoTime stamp;
  int pulse = 0;
};

Blend blend_of(const Flash* first, const Flash* last) {
  Blend blend{first->time, kNoTime, first->pulse};
  MonoTime start;
  std::int64_t sum = 0, stamps = 0, stamped = 0;
  for (const Flash* f = first; f != last; ++f) {
    sum += (f->time - first->time).count();
    if (!known(f->stamp)) continue;
    if (stamped++ == 0) start = f->stamp;
    stamps += (f->stamp - start).count();
  }
  blend.time = first->time + nanoseconds(sum / (last - first));
  if (stamped > 0) blend.stamp = start + nanoseconds(stamps / stamped);
  return blend;
}

std::vector<Blend> blends_of(const std::vector<Flash>& flashes) {
  std::vector<Blend> blends;
  blends.reserve(flashes.size());
  for (std::size_t first = 0; first < flashes.size();) {
    std::size_t last = first + 1;
    while (last < flashes.size() && flashes[last].time - flashes[last - 1].time <= kBlend) ++last;
    blends.push_back(blend_of(flashes.data() + first, flashes.data() + last));
    first = last;
  }
  return blends;
}

class Film {
 public:
  Film(const Scene& scene, const ThrownBall& ball)
      : camera_(scene), ball_(ball), flash_s_(scene.lamps.flash_s), radius_m_(scene.ball.radius_m()) {
    if (scene.camera.distance_m > 0.0)
      nearest_m_ = scene.camera.distance_m - scene.ball.diameter_m - ball.path.off_plane_m();
  }

  /// Adds the image if there is one. True: none will follow on this side of the impact.
  bool add(const Blend& blend, std::vector<FilmImage>& images) {
    if (blend.time < ball_.released) return true;
    const double time_s = to_seconds(blend.time - ball_.touchdown);
    if (last_view_ == View::above && surely_above(time_s)) return false;
    // The whole light of a flash costs little more than its begin; where the ball is out of sight that is
    // enough.
    if (last_view_ != View::seen && judge(time_s, ball_.path.at(time_s)) != View::seen)
      return last_view_ == View::left;
    const auto [begin, mean] = ball_.path.lit(time_s, flash_s_);
    if (judge(time_s, begin) == View::seen) images.push_back({blend.pulse, blend.time, blend.stamp, mean});
    return last_view_ == View::left;
  }

 private:
  enum class View { seen, above, left };

  View judge(double time_s, const BallState& begin) {
    const double x_m = begin.x_m + ball_.path.spot_m();
    if (ball_.path.beyond_last_bounce(time_s, begin) || !camera_.may_see(x_m) || begin.z_m > nearest_m_)
      last_view_ = View::left;
    else
      last_view_ = camera_.sees(x_m, begin.y_m) ? View::seen : View::above;
    return last_view_;
  }

  bool surely_above(double time_s) const {
    if (time_s < 0.0) return false;
    constexpr double kUnsure_m = 0.02;  // twice what the rough place may be off
    const BallPath::Place p = ball_.path.roughly_at(time_s);
    const double x_m = std::abs(p.x_m + ball_.path.spot_m());
    return p.y_m > 2.0 * radius_m_ + kUnsure_m && x_m < camera_.half_width_m() - kUnsure_m &&
           !camera_.sees(0.0, p.y_m - kUnsure_m);
  }

  Camera camera_;
  const ThrownBall& ball_;
  double flash_s_;
  double radius_m_;
  double nearest_m_ = std::numeric_limits<double>::infinity();  ///< to the lens, from the plane of touchdown
  View last_view_ = View::seen;
};

}  // namespace

MonoTime flash_time(const Pulse& pulse) {
  if (pulse.flashes.empty()) return kNoTime;
  std::int64_t sum = 0;
  for (const MonoTime time : pulse.flashes) sum += to_ns(time) - to_ns(pulse.edge);
  return pulse.edge + nanoseconds(sum / static_cast<std::int64_t>(pulse.flashes.size()));
}

std::optional<int> place_from_impact(const Exposure& exposure, std::size_t pulse) {
  if (!exposure.ball || pulse >= exposure.pulses.size()) return std::nullopt;
  const auto before = std::ranges::count_if(
      exposure.pulses, [&](const Pulse& p) { return p.edge < exposure.ball->touchdown; });
  const auto index = static_cast<std::ptrdiff_t>(pulse);
  return static_cast<int>(index < before ? index - before : index - before + 1);
}

bool shows_impact(const Exposure& exposure) {
  return exposure.ball && known(exposure.opened) && exposure.ball->touchdown >= exposure.opened &&
         exposure.ball->touchdown <= exposure.closed;
}

std::vector<FilmImage> film_images(const Scene& scene, const Exposure& exposure) {
  std::vector<FilmImage> images;
  if (!exposure.ball || !known(exposure.opened)) return images;
  const std::vector<Blend> blends = blends_of(flashes_on_film(exposure));
  Film film(scene, *exposure.ball);
  const auto after = std::ranges::lower_bound(blends, exposure.ball->touchdown, {}, &Blend::time);
  // Outwards from the impact: nothing more is seen once the ball has left the view at its side.
  for (auto blend = after; blend != blends.begin();) {
    if (film.add(*--blend, images)) break;
  }
  std::ranges::reverse(images);
  for (auto blend = after; blend != blends.end(); ++blend) {
    if (film.add(*blend, images)) break;
  }
  return images;
}

namespace {}  // namespace

Draws& LampModel::draws(int shot) {
  if (!draws_ || draws_shot_ != shot) {
    const Purpose purpose = lamp_ == Lamp::a ? Purpose::lamp_a : Purpose::lamp_b;
    draws_.emplace(seed_, purpose, static_cast<std::uint64_t>(shot));
    draws_shot_ = shot;
  }
  return *draws_;
}

FlashTimes LampModel::on_pulse(MonoTime edge, const FlashPlace& place, std::vector<FaultKind>& occurred) {
  // Drawn for every pulse, so that a fault does not shift the jitter of the flashes after it.
  Draws& jitter = draws(place.shot);
  const double delay_s = std::max(0.0, jitter.normal(scene_.lamps.delay_s, scene_.lamps.jitter_s));
  sensor_jitter_s_ = jitter.normal(0.0, scene_.sensors.jitter_s);
  if (shot_fault(scene_.faults, FaultKind::lamp_dead, place.shot, lamp_)) {
    occurred.push_back(FaultKind::lamp_dead);
    return {};
  }
  if (flash_fault(scene_.faults, FaultKind::flash_missing, place, lamp_)) {
    occurred.push_back(FaultKind::flash_missing);
    return {};
  }
  MonoTime flash = edge + from_seconds(delay_s);
  if (const Fault* late = flash_fault(scene_.faults, FaultKind::flash_late, place, lamp_)) {
    occurred.push_back(FaultKind::flash_late);
    flash = flash + late->delay;
  }
  if (known(last_flash_) && flash - last_flash_ < from_seconds(scene_.lamps.recharge_s)) return {};
  last_flash_ = flash;
  FlashTimes flashes{flash};
  if (const Fault* twice = flash_fault(scene_.faults, FaultKind::flash_double, place, lamp_)) {
    occurred.push_back(FaultKind::flash_double);
    flashes.push_back(flash + twice->delay);  // the fault is that it does so without a full capacitor
    last_flash_ = flashes.back();
  }
  return flashes;
}

bool LampModel::sensor_works(int shot) const {
  return shot_fault(scene_.faults, FaultKind::sensor_dead, shot, lamp_) == nullptr;
}

}  // namespace strobe::sim
