#include "sim/rig/tablet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"
#include "sim/rig/pixels.hpp"

namespace strobe::sim {

namespace {

using reduction::BallImage;
using reduction::Leg;
using reduction::PointPx;

/// Where the surface is measured, as shares of the view's half width: well apart, clear of the impact.
constexpr std::array kSurfacePoints{-0.95, -0.70, 0.70, 0.95};

constexpr double kMaxTilt_rad = 75.0 * std::numbers::pi / 180.0;

std::optional<double> known(double sd) { return sd > 0.0 ? std::optional(sd) : std::nullopt; }

Leg leg_seen(const BallState& state, double time_s, double dwell_s, double visible_m) {
  if (state.top_drop_m > visible_m) return Leg::contact;
  return time_s < 0.5 * dwell_s ? Leg::incoming : Leg::rebound;
}

class Hand {
 public:
  Hand(const Scene& scene, std::uint64_t seed, int shot, bool perfect)
      : scene_(scene),
        camera_(scene),
        draws_(seed, Purpose::tablet, static_cast<std::uint64_t>(shot)),
        tilt_draws_(seed, Purpose::tablet_tilt, static_cast<std::uint64_t>(shot)),
        error_(perfect ? 0.0 : 1.0),
        centre_sd_px_(scene.tablet.centre_sd_m * scene.camera.px_per_m) {}

  PointPx point(PointPx p) {
    p.x += error(centre_sd_px_);
    p.y += error(centre_sd_px_);
    return p;
  }
  PointPx surface_point(double x_m) { return point(camera_.project(x_m, 0.0)); }

  BallImage image(const FilmImage& film, const BallPath& path, MonoTime touchdown) {
    const BallState& s = film.state;
    const double x_m = s.x_m + path.spot_m();
    const double off_plane_m = path.off_plane_m() + s.z_m;
    const std::optional<LineView> line = line_of(s, x_m, off_plane_m, path.planar());
    const PixelMeasurement seen = measure(s, x_m, off_plane_m, line);
    BallImage image;
    image.leg =
        leg_seen(s, to_seconds(film.time - touchdown), path.dwell_s(), scene_.tablet.visible_flattening_m);
    image.centre_px = point(seen.centre_px);
    image.diameter_px = seen.diameter_px + error(kDiameterNoiseRatio * centre_sd_px_);
    const double equator_error = error(scene_.tablet.equator_sd_rad);
    if (seen.equator_rad && scene_.ball_appearance.line)
      image.equator_rad = modulo_pi(*seen.equator_rad + equator_error);
    if (line) tell_tilt(*line, image);
    const PointPx top = point(camera_.project(x_m, scene_.ball.diameter_m - s.top_drop_m, off_plane_m));
    if (image.leg == Leg::contact) image.top_px = top;
    image.source = "hand";
    return image;
  }

  void state_noise(reduction::Frame& frame) {
    frame.centre_sd_px = known(centre_sd_px_);
    frame.surface_sd_px = known(centre_sd_px_);
    frame.diameter_sd_px = known(kDiameterNoiseRatio * centre_sd_px_);
    frame.equator_sd_rad = known(scene_.tablet.equator_sd_rad);
    if (scene_.tablet.calibration_sd < 0.0) return;
    const double sd = scene_.tablet.calibration_sd * camera_.px_per_m();
    frame.px_per_m = camera_.px_per_m() + error(sd);
    frame.px_per_m_sd = sd;
    if (scene_.camera.distance_m > 0.0)
      frame.lens = reduction::Lens{scene_.camera.distance_m, camera_.foot_px()};
  }

  /// Of a calibrated camera: as who knows where the lens is undoes a ball's oval.
  static void undo_ovals(reduction::Frame& frame) {
    if (!frame.lens) return;
    const double lens_px = frame.lens->distance_m * *frame.px_per_m;
    for (BallImage& image : frame.images) {
      const double aside =
          std::hypot(image.centre_px.x - frame.lens->foot_px.x, image.centre_px.y - frame.lens->foot_px.y) /
          lens_px;
      image.diameter_px /= std::pow(1.0 + aside * aside, 0.25);
    }
  }

  double half_width_m() const { return camera_.half_width_m(); }

 private:
  /// Where the line may be tilted, or its tilt is measured.
  std::optional<LineView> line_of(const BallState& s, double x_m, double off_plane_m, bool planar) const {
    const BallAppearanceSettings& ball = scene_.ball_appearance;
    if (planar && ball.line_offset == 0.0 && scene_.tablet.equator_tilt_sd_rad == 0.0) return std::nullopt;
    const double tilt = ball.line_tilt_rad.value_or(0.0);
    return camera_.line(x_m, s.y_m, off_plane_m,
                        s.attitude() * Eigen::Vector3d(0.0, std::cos(tilt), std::sin(tilt)),
                        ball.line_offset);
  }

  /// Nobody sees a line that is all on the outline.
  void tell_tilt(const LineView& line, BallImage& image) {
    const double tilt_sd_rad = scene_.tablet.equator_tilt_sd_rad;
    const double tilt_rad = line.tilt_rad + error_ * tilt_draws_.normal(0.0, tilt_sd_rad);
    if (std::abs(line.tilt_rad) > kMaxTilt_rad) image.equator_rad.reset();
    if (!image.equator_rad || tilt_sd_rad == 0.0) return;
    // Of the direction in which the equator was read.
    const bool along = std::cos(*image.equator_rad - line.equator_rad) > 0.0;
    image.equator_tilt_rad =
        std::clamp(along ? tilt_rad : -tilt_rad, -0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
    image.equator_tilt_sd_rad = tilt_sd_rad;
  }

  PixelMeasurement measure(const BallState& s, double x_m, double off_plane_m,
                           const std::optional<LineView>& line) {
    BallView view = camera_.view(x_m, s.y_m, off_plane_m, s.equator_rad);
    if (line) view.equator_rad = line->equator_rad;
    if (!scene_.camera.pixels) return {view.centre_px, view.diameter_px(), view.equator_rad};
    const double flash_s = scene_.lamps.flash_s;
    const PointPx a = camera_.project(x_m, s.y_m, off_plane_m);
    const PointPx b = camera_.project(x_m + flash_s * s.vx_mps, s.y_m + flash_s * s.vy_mps, off_plane_m);
    const double turn = flash_s * (scene_.camera.mirrored ? -s.omega_radps : s.omega_radps);
    return grid_.measure(view, {b.x - a.x, b.y - a.y, turn});
  }

  double error(double sd) { return draws_.normal(0.0, error_ * sd); }

  const Scene& scene_;
  Camera camera_;
  PixelGrid grid_;
  Draws draws_, tilt_draws_;
  double error_;
  double centre_sd_px_;
};

bool unseen(const Scene& scene, const Exposure& exposure, int pulse) {
  const FlashPlace place{.shot = exposure.shot,
                         .index = pulse,
                         .from_impact = place_from_impact(exposure, static_cast<std::size_t>(pulse))};
  return flash_fault(scene.faults, FaultKind::image_unseen, place, Lamp::a) != nullptr;
}

Digitized digitize_by(Hand&& hand, const Scene& scene, const Exposure& exposure) {
  Digitized result;
  reduction::Frame& frame = result.frame;
  frame.ball_diameter_m = scene.ball.diameter_m;
  frame.surface_angle_deg =
      scene.surface_angle_rad * (scene.camera.mirrored ? -180.0 : 180.0) / std::numbers::pi;
  frame.temperature_c = scene.air.temperature_c;
  frame.ball_mass_kg = scene.ball.mass_kg;
  frame.ball_alpha = scene.ball.alpha;
  if (scene.kind) frame.air_law = scene.kind->air;
  frame.fastest_spin_radps = known_fastest_spin_radps(scene);
  if (scene.air.density_kgpm3 >= 0.0) frame.air_density_kgpm3 = scene.air.density_kgpm3;  // by a barometer
  hand.state_noise(frame);
  for (const double share : kSurfacePoints)
    frame.surface_px.push_back(hand.surface_point(share * hand.half_width_m()));
  std::ranges::sort(frame.surface_px, {}, &PointPx::x);
  const std::vector<FilmImage> film_of_all = film_images(scene, exposure);
  frame.images.reserve(film_of_all.size());
  result.image_pulse.reserve(film_of_all.size());
  for (const FilmImage& film : film_of_all) {
    const BallPath& path = exposure.ball->path;
    if (path.bounced_again(to_seconds(film.time - exposure.ball->touchdown))) break;
    BallImage image = hand.image(film, path, exposure.ball->touchdown);
    if (unseen(scene, exposure, film.pulse)) continue;
    frame.images.push_back(std::move(image));
    result.image_pulse.push_back(film.pulse);
    result.image_stamp.push_back(film.stamp);
  }
  Hand::undo_ovals(frame);
  return result;
}

}  // namespace

Digitized digitize(const Scene& scene, std::uint64_t seed, const Exposure& exposure) {
  return digitize_by(Hand(scene, seed, exposure.shot, false), scene, exposure);
}

Digitized digitize_perfectly(const Scene& scene, std::uint64_t seed, const Exposure& exposure) {
  return digitize_by(Hand(scene, seed, exposure.shot, true), scene, exposure);
}

std::vector<int> image_pulses(const Scene& scene, const Exposure& exposure) {
  std::vector<int> pulses;
  for (const FilmImage& film : film_images(scene, exposure))
    if (!unseen(scene, exposure, film.pulse)) pulses.push_back(film.pulse);
  return pulses;
}

}  // namespace strobe::sim
