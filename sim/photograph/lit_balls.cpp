#include "sim/photograph/lit_balls.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/messages/parsed_json.hpp"
#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"
#include "sim/rig/pixels.hpp"
#include "sim/rig/truth.hpp"

namespace strobe::sim {

namespace {

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
    LitBall ball{optics_.from_surface(s.x_m + path.spot_m(), y_m, path.off_plane_m() + s.z_m),
                 scene_.camera.mirrored ? -s.equator_rad : s.equator_rad, light};
    if (!path.planar()) ball.turned = as_seen(s.turned.toRotationMatrix());
    return ball;
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
  /// A mirrored camera sees the mirror's image of the motion.
  Eigen::Matrix3d as_seen(Eigen::Matrix3d turned) const {
    const Eigen::Vector3d mirror(scene_.camera.mirrored ? -1.0 : 1.0, 1.0, 1.0);
    return mirror.asDiagonal() * turned * mirror.asDiagonal();
  }

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

using nlohmann::json;
using reduction::PointPx;

constexpr int kTruePoints = 256;

/// The scene's camera with a perfect lens, square to the plane.
Scene without_distortion(Scene scene) {
  scene.camera.distortion = scene.camera.swing_rad = scene.camera.tilt_rad = 0.0;
  return scene;
}

class Truth {
 public:
  Truth(const Scene& scene, const Appearance& appearance)
      : scene_(without_distortion(scene)),
        appearance_(appearance),
        camera_(scene_),
        straight_(scene_),
        optics_(scene) {}

  ImageTruth image(const BallImageOnSensor& on_sensor, const Exposure& exposure) const {
    const FilmImage& film = on_sensor.film;
    const BallState& s = film.state;
    const BallPath& path = exposure.ball->path;
    const double radius_m = scene_.ball.radius_m();
    const bool contact = s.top_drop_m > 0.0;
    const double x_m = s.x_m + path.spot_m();
    const double y_m = contact ? radius_m - s.top_drop_m : s.y_m;
    const double depth_m = path.off_plane_m() + s.z_m;
    const BallView view = camera_.view(x_m, y_m, depth_m, s.equator_rad);
    ImageTruth image;
    image.depth_m = depth_m;
    image.flash_index = film.pulse;
    image.time_s = to_seconds(film.time - exposure.pulses.front().edge) + 0.5 * scene_.lamps.flash_s;
    const bool after = to_seconds(film.time - exposure.ball->touchdown) > 0.5 * path.dwell_s();
    image.leg = contact ? reduction::Leg::contact
                : after ? reduction::Leg::rebound
                        : reduction::Leg::incoming;
    image.centre_px = view.centre_px;
    image.diameter_px = view.diameter_px();
    const double tilt = appearance_.ball.line_tilt_rad;
    const LineView line =
        camera_.line(x_m, y_m, depth_m, s.attitude() * Eigen::Vector3d(0.0, std::cos(tilt), std::sin(tilt)),
                     appearance_.ball.line_offset);
    image.equator_tilt_rad = line.tilt_rad;
    // The same but for its last digits, as it was before lines could be out of the plane.
    image.equator_rad = path.planar() && appearance_.ball.line_offset == 0.0
                            ? modulo_pi(line_seen(on_sensor.middle))
                            : line.equator_rad;
    image.top_px = top_of(view);
    image.top_drop_px = s.top_drop_m * scale_at(depth_m);
    if (contact) {
      const double half_m = std::sqrt(std::max(0.0, radius_m * radius_m - y_m * y_m));
      image.contact_width_px = 2.0 * half_m * scale_at(depth_m);
    }
    tell_share(on_sensor.middle.centre, image);
    return image;
  }

  double scale_at(double off_plane_m) const {
    const double distance_m = scene_.camera.distance_m;
    return scene_.camera.px_per_m * (distance_m > 0.0 ? distance_m / (distance_m - off_plane_m) : 1.0);
  }
  PointPx surface(double share) const { return camera_.project(share * camera_.half_width_m(), 0.0); }
  const SensorSize& sensor() const { return optics_.sensor(); }

 private:
  PointPx plane_px(const Vec2& image) const { return {image.x, optics_.sensor().height - 1.0 - image.y}; }

  /// Through the images of the two points where the line, a great circle that may be tilted against the line
  /// of sight, leaves the outline: n = cos(psi)·e + sin(psi)·f with (C - lens)·n = -R.
  double line_seen(const LitBall& ball) const {
    const double tilt = appearance_.ball.line_tilt_rad;
    const double c = std::cos(ball.angle_rad), s = std::sin(ball.angle_rad);
    const Vec3 e{c, s, 0.0};
    const Vec3 f{std::sin(tilt) * s, -std::sin(tilt) * c, std::cos(tilt)};
    const double radius_m = scene_.ball.radius_m();
    double first = 0.0, second = std::numbers::pi;
    if (optics_.perspective()) {
      const Vec3 from_lens = ball.centre - Vec3{0.0, 0.0, optics_.distance_m()};
      const double a = dot(from_lens, e), b = dot(from_lens, f);
      const double middle = std::atan2(b, a);
      const double half = std::acos(std::clamp(-radius_m / std::hypot(a, b), -1.0, 1.0));
      first = middle + half;
      second = middle - half;
    }
    const auto seen = [&](double psi) {
      return plane_px(straight_.image_of(ball.centre + radius_m * (std::cos(psi) * e + std::sin(psi) * f)));
    };
    const PointPx p = seen(first), q = seen(second);
    return std::atan2(p.y - q.y, p.x - q.x);
  }

  PointPx top_of(const BallView& view) const {
    const PointPx a = camera_.project(0.0, 0.0), b = camera_.project(0.0, scene_.camera.height_m);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const double ux = (b.x - a.x) / length, uy = (b.y - a.y) / length;
    const double c = std::cos(view.axis_rad), s = std::sin(view.axis_rad);
    const double along = c * ux + s * uy, across = c * uy - s * ux;
    const double aa = view.along_px * view.along_px, bb = view.across_px * view.across_px;
    const double reach = std::sqrt(aa * along * along + bb * across * across);
    return {view.centre_px.x + (c * aa * along - s * bb * across) / reach,
            view.centre_px.y + (s * aa * along + c * bb * across) / reach};
  }

  void tell_share(const Vec3& centre, ImageTruth& image) const {
    const std::vector<Vec2> outline = outline_on_sensor(optics_, centre, scene_.ball.radius_m(), kTruePoints);
    const auto inside = std::ranges::count_if(outline, [&](const Vec2& p) {
      return p.x >= -0.5 && p.y >= -0.5 && p.x <= sensor().width - 0.5 && p.y <= sensor().height - 0.5;
    });
    image.whole = inside == kTruePoints;
    image.share_on_sensor = static_cast<double>(inside) / kTruePoints;
  }

  Scene scene_;
  const Appearance& appearance_;
  Camera camera_;
  Optics straight_;
  Optics optics_;
};

std::optional<double> stamp_s(const Pulse& pulse, MonoTime origin) {
  double sum = 0.0;
  int stamped = 0;
  for (const MonoTime stamp : pulse.stamps) {
    if (!known(stamp)) continue;
    sum += to_seconds(stamp - origin);
    ++stamped;
  }
  return stamped > 0 ? std::optional(sum / stamped) : std::nullopt;
}

json point(const PointPx& p) { return json::array({p.x, p.y}); }

/// What only a scene that is not planar tells, so that others' lines stay as they are.
bool is_spatial(const Scene& scene) {
  return !scene.machine.planar() || scene.ball_appearance.line_offset != 0.0;
}

json image_json(const Scene& scene, const ImageTruth& i) {
  json object = {
      {"flash_index", i.flash_index},        {"time_s", i.time_s},           {"leg", name(i.leg)},
      {"centre_px", point(i.centre_px)},     {"diameter_px", i.diameter_px}, {"equator_rad", i.equator_rad},
      {"top_px", point(i.top_px)},           {"top_drop_px", i.top_drop_px}, {"whole", i.whole},
      {"share_on_sensor", i.share_on_sensor}};
  object["contact_width_px"] = i.contact_width_px ? json(*i.contact_width_px) : json(nullptr);
  if (!is_spatial(scene)) return object;
  object["equator_tilt_rad"] = i.equator_tilt_rad;
  object["depth_m"] = i.depth_m;
  return object;
}

json appearance_json(const Scene& scene, const Appearance& appearance) {
  json object = {{"blur_px", appearance.blur_px},
                 {"defocus_px", scene.photograph.defocus_px},
                 {"exposure", scene.photograph.exposure},
                 {"bits", scene.photograph.bits},
                 {"line", appearance.ball.line},
                 {"line_width_m", appearance.ball.line_width_m},
                 {"line_contrast", appearance.ball.line_contrast},
                 {"line_tilt_rad", appearance.ball.line_tilt_rad},
                 {"grain", appearance.ball.grain},
                 {"fuzz_px", appearance.ball.fuzz_px},
                 {"lamp_powers", {appearance.lamps[0].power, appearance.lamps[1].power}},
                 {"wall", appearance.background.wall},
                 {"plate_brightness", appearance.background.plate_brightness}};
  if (is_spatial(scene)) object["line_offset"] = appearance.ball.line_offset;
  return object;
}

}  // namespace

Eigen::Matrix3d LitBall::attitude() const {
  const Eigen::Matrix3d first = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return turned ? Eigen::Matrix3d(*turned * first) : first;
}

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

PhotographTruth photograph_truth(const Scene& scene, const Exposure& exposure, const Appearance& appearance,
                                 const std::vector<BallImageOnSensor>& images) {
  const Truth truth(scene, appearance);
  PhotographTruth result;
  result.width_px = truth.sensor().width;
  result.height_px = truth.sensor().height;
  result.px_per_m = scene.camera.px_per_m;
  result.px_per_m_of_ball = truth.scale_at(exposure.ball ? exposure.ball->path.off_plane_m() : 0.0);
  result.surface_px = {truth.surface(-1.0), truth.surface(1.0)};
  std::ranges::sort(result.surface_px, {}, &PointPx::x);
  for (const Pulse& pulse : exposure.pulses)
    result.flash_times_s.push_back(stamp_s(pulse, exposure.pulses.front().edge));
  for (const BallImageOnSensor& image : images) result.images.push_back(truth.image(image, exposure));
  return result;
}

std::string photograph_line(const Scene& scene, const Exposure& exposure, int shot_id,
                            const Appearance& appearance, const PhotographTruth& truth,
                            const std::string& file) {
  json line = messages::parsed_json<json>(truth_line(scene, exposure, shot_id));
  line["file"] = file.empty() ? json(nullptr) : json(file);
  line["width_px"] = truth.width_px;
  line["height_px"] = truth.height_px;
  line["px_per_m"] = truth.px_per_m;
  line["px_per_m_of_ball"] = truth.px_per_m_of_ball;
  line["ball_diameter_m"] = scene.ball.diameter_m;
  line["surface_px"] = json::array();
  for (const PointPx& p : truth.surface_px) line["surface_px"].push_back(point(p));
  line["flash_times_s"] = json::array();
  for (const auto& time : truth.flash_times_s)
    line["flash_times_s"].push_back(time ? json(*time) : json(nullptr));
  line["images"] = json::array();
  for (const ImageTruth& image : truth.images) line["images"].push_back(image_json(scene, image));
  line["appearance"] = appearance_json(scene, appearance);
  return messages::json_text(line);
}

}  // namespace strobe::sim
