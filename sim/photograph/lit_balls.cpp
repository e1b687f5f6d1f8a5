#include "sim/photograph/lit_balls.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr double kSpacing_px = 0.25;  // of the balls that a smeared one is the mean of
constexpr int kMaxInstants = 64;
constexpr int kOutlinePoints = 64;

std::array<double, 2> light_of(const Pulse& pulse, std::uint64_t index, const Appearance& appearance,
                               double power_sd) {
  Draws draws(appearance.noise, Purpose::flash_power, index + 1);
  std::array<double, 2> light{};
  const bool unknown = pulse.lamps[0] + pulse.lamps[1] == 0;
  for (std::size_t lamp = 0; lamp < 2; ++lamp) {
    const double power = std::max(0.0, 1.0 + power_sd * draws.normal());
    const int flashes = unknown && !pulse.flashes.empty() ? 1 : pulse.lamps[lamp];
    light[lamp] = power * flashes * appearance.lamps[lamp].power;
  }
  return light;
}

/// As the scene, but with every ball in view that may be on the sensor.
Scene with_all_in_view(const Scene& scene) {
  Scene wide = scene;
  const SensorSize sensor = sensor_size(scene);
  const CameraSettings& c = scene.camera;
  const double across = std::hypot(sensor.width, sensor.height) + std::hypot(c.origin_x_px, c.origin_y_px);
  const double reach = 2.0 * (across / c.px_per_m + scene.ball.diameter_m);
  wide.camera.half_width_m = reach;
  wide.camera.height_m = reach;
  return wide;
}

bool on_sensor(const Optics& optics, const Vec3& centre, double radius_m) {
  const auto inside = [&](const Vec2& p) {
    return p.x > -1.0 && p.y > -1.0 && p.x < optics.sensor().width && p.y < optics.sensor().height;
  };
  return inside(optics.image_of(centre)) ||
         std::ranges::any_of(outline_on_sensor(optics, centre, radius_m, kOutlinePoints), inside);
}

class Flashes {
 public:
  Flashes(const Scene& scene, const Exposure& exposure, const Appearance& appearance)
      : scene_(scene), exposure_(exposure), appearance_(appearance), optics_(scene) {}

  LitBall ball(const BallState& s, const std::array<double, 2>& light) const {
    const BallPath& path = exposure_.ball->path;
    // Where the top is, not where the middle of the mass is.
    const double y_m = s.top_drop_m > 0.0 ? scene_.ball.radius_m() - s.top_drop_m : s.y_m;
    return {optics_.from_surface(s.x_m + path.spot_m(), y_m, path.off_plane_m()),
            scene_.camera.mirrored ? -s.equator_rad : s.equator_rad, light};
  }

  BallImageOnSensor image(const FilmImage& film, double share) const {
    const auto pulse = static_cast<std::size_t>(film.pulse);
    std::array<double, 2> light =
        light_of(exposure_.pulses[pulse], pulse, appearance_, scene_.photograph.flash_power_sd);
    for (double& l : light) l *= share;
    const auto& settings = scene_.photograph;
    const FilmImage mean = later(film, settings.second_flash * settings.second_flash_s);
    BallImageOnSensor image{mean, ball(mean.state, light), {}};
    add_flash(film, 1.0 - settings.second_flash, light, image);
    if (settings.second_flash > 0.0)
      add_flash(later(film, settings.second_flash_s), settings.second_flash, light, image);
    return image;
  }

  const Optics& optics() const { return optics_; }

 private:
  int instants_of(const BallState& s) const {
    const double way_px = std::hypot(s.vx_mps, s.vy_mps) * scene_.lamps.flash_s * scene_.camera.px_per_m;
    return std::clamp(static_cast<int>(std::ceil(way_px / kSpacing_px)), 1, kMaxInstants);
  }

  FilmImage later(FilmImage film, double by_s) const {
    if (by_s == 0.0) return film;
    film.time += from_seconds(by_s);
    film.state = exposure_.ball->path.mean_over(to_seconds(film.time - exposure_.ball->touchdown),
                                                scene_.lamps.flash_s);
    return film;
  }

  void add_flash(const FilmImage& film, double share, std::array<double, 2> light,
                 BallImageOnSensor& image) const {
    for (double& l : light) l *= share;
    const int instants = instants_of(film.state);
    for (int i = 0; i < instants; ++i) image.balls.push_back(at_instant(film, light, i, instants));
  }

  LitBall at_instant(const FilmImage& film, std::array<double, 2> light, int i, int instants) const {
    if (instants == 1) return ball(film.state, light);
    const double since_s = to_seconds(film.time - exposure_.ball->touchdown);
    for (double& l : light) l /= instants;
    return ball(exposure_.ball->path.at(since_s + scene_.lamps.flash_s * (i + 0.5) / instants), light);
  }

  const Scene& scene_;
  const Exposure& exposure_;
  const Appearance& appearance_;
  Optics optics_;
};

}  // namespace

std::vector<Vec2> outline_on_sensor(const Optics& optics, const Vec3& centre, double radius_m, int points) {
  // The circle on the sphere where rays touch it: from infinity a great circle across the line of sight.
  Vec3 axis{0.0, 0.0, 1.0};
  double height = 0.0;
  double radius = radius_m;
  if (optics.perspective()) {
    const Vec3 to_lens = Vec3{0.0, 0.0, optics.distance_m()} - centre;
    const double away = std::sqrt(dot(to_lens, to_lens));
    axis = (1.0 / away) * to_lens;
    height = radius_m * radius_m / away;
    radius = radius_m * std::sqrt(1.0 - (radius_m / away) * (radius_m / away));
  }
  const double flat = std::hypot(axis.x, axis.z);
  const Vec3 e{axis.z / flat, 0.0, -axis.x / flat};
  const Vec3 f{axis.y * e.z - axis.z * e.y, axis.z * e.x - axis.x * e.z, axis.x * e.y - axis.y * e.x};
  std::vector<Vec2> outline;
  outline.reserve(static_cast<std::size_t>(points));
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / points;
    const Vec3 rim = radius * (std::cos(angle) * e + std::sin(angle) * f);
    outline.push_back(optics.image_of(centre + height * axis + rim));
  }
  return outline;
}

std::vector<BallImageOnSensor> more_lit_balls(const Scene& scene, const Exposure& exposure,
                                              const Appearance& appearance) {
  std::vector<BallImageOnSensor> images;
  for (const ThrownBall& ball : exposure.more_balls) {
    Exposure other = exposure;
    other.ball = ball;
    for (BallImageOnSensor& image : lit_balls(scene, other, appearance)) images.push_back(std::move(image));
  }
  return images;
}

std::vector<BallImageOnSensor> lit_balls(const Scene& scene, const Exposure& exposure,
                                         const Appearance& appearance) {
  const std::vector<FilmImage> films = film_images(with_all_in_view(scene), exposure);
  const Flashes flashes(scene, exposure, appearance);
  std::vector<BallImageOnSensor> images;
  for (const FilmImage& film : films) {
    const auto same = std::ranges::count(films, film.pulse, &FilmImage::pulse);
    BallImageOnSensor image = flashes.image(film, 1.0 / static_cast<double>(same));
    if (image.middle.light[0] + image.middle.light[1] <= 0.0) continue;
    if (on_sensor(flashes.optics(), image.middle.centre, scene.ball.radius_m()))
      images.push_back(std::move(image));
  }
  return images;
}

std::array<double, 2> light_of_all(const Exposure& exposure, const Appearance& appearance, double power_sd) {
  std::array<double, 2> sum{};
  if (!known(exposure.opened)) return sum;
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i) {
    const Pulse& pulse = exposure.pulses[i];
    const MonoTime time = flash_time(pulse);
    if (!known(time) || time < exposure.opened || time > exposure.closed) continue;
    const std::array<double, 2> light = light_of(pulse, i, appearance, power_sd);
    sum[0] += light[0];
    sum[1] += light[1];
  }
  return sum;
}

}  // namespace strobe::sim
