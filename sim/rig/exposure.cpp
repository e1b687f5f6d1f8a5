#include "sim/rig/exposure.hpp"

#include <algorithm>

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
      const MonoTime stamp = k < pulse.stamps.size() ? pulse.stamps[k] : MonoTime::never();
      if (time >= exposure.opened && time <= exposure.closed)
        flashes.push_back({time, stamp, static_cast<int>(i)});
    }
  }
  std::ranges::sort(flashes, {}, &Flash::time);
  return flashes;
}

MonoTime mean_time(const Flash* first, const Flash* last) {
  std::int64_t sum = 0;
  for (const Flash* f = first; f != last; ++f) sum += f->time.ns - first->time.ns;
  return first->time + nanoseconds(sum / (last - first));
}

MonoTime mean_stamp(const Flash* first, const Flash* last) {
  MonoTime start = MonoTime::never();
  std::int64_t sum = 0;
  std::int64_t known = 0;
  for (const Flash* f = first; f != last; ++f) {
    if (!f->stamp.known()) continue;
    if (known++ == 0) start = f->stamp;
    sum += f->stamp.ns - start.ns;
  }
  return known == 0 ? start : start + nanoseconds(sum / known);
}

}  // namespace

MonoTime flash_time(const Pulse& pulse) {
  if (pulse.flashes.empty()) return MonoTime::never();
  std::int64_t sum = 0;
  for (const MonoTime time : pulse.flashes) sum += time.ns - pulse.edge.ns;
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
  return exposure.ball && exposure.opened.known() && exposure.ball->touchdown >= exposure.opened &&
         exposure.ball->touchdown <= exposure.closed;
}

std::vector<FilmImage> film_images(const Scene& scene, const Exposure& exposure) {
  std::vector<FilmImage> images;
  if (!exposure.ball || !exposure.opened.known()) return images;
  const Camera camera(scene);
  const std::vector<Flash> flashes = flashes_on_film(exposure);
  const ThrownBall& ball = *exposure.ball;
  for (std::size_t first = 0; first < flashes.size();) {
    std::size_t last = first + 1;
    while (last < flashes.size() && flashes[last].time - flashes[last - 1].time <= kBlend) ++last;
    const MonoTime time = mean_time(&flashes[first], flashes.data() + last);
    const BallState state = ball.path.at((time - ball.touchdown).seconds());
    if (camera.sees(state.x_m + ball.path.spot_m(), state.y_m))
      images.push_back(
          {flashes[first].pulse, time, mean_stamp(&flashes[first], flashes.data() + last), state});
    first = last;
  }
  return images;
}

}  // namespace strobe::sim
