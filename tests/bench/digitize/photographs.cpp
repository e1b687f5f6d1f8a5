#include "tests/bench/digitize/photographs.hpp"

#include <chrono>
#include <opencv2/imgcodecs.hpp>

#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::bench::digitize {

namespace {

std::vector<TrueImage> true_images(const sim::Scene& scene, const sim::PhotographTruth& truth) {
  std::vector<TrueImage> images;
  for (const sim::ImageTruth& image : truth.images)
    images.push_back({.leg = image.leg,
                      .centre_px = image.centre_px,
                      .diameter_px = image.diameter_px,
                      .equator_rad = scene.ball_look.line ? std::optional(image.equator_rad) : std::nullopt,
                      .top_px = image.top_px,
                      .contact_width_px = image.contact_width_px,
                      .whole = image.whole});
  return images;
}

std::vector<double> seen_flashes(const sim::PhotographTruth& truth) {
  std::vector<double> times_s;
  for (const auto& time_s : truth.flash_times_s)
    if (time_s) times_s.push_back(*time_s);
  return times_s;
}

}  // namespace

Result<KnownPhotograph> known_photograph(const sim::Scene& scene, std::uint64_t seed, int shot) {
  const auto simulated = sim::shoot(scene, seed, shot);
  if (!simulated) return tl::unexpected(simulated.error());
  const auto rendered = sim::render(scene, seed, simulated->exposure);
  if (!rendered) return tl::unexpected(rendered.error());
  std::vector<unsigned char> bytes;
  cv::imencode(".pgm", rendered->pixels, bytes);
  const auto start = std::chrono::steady_clock::now();
  auto photograph = strobe::digitize::decode_photograph(bytes, scene.name);
  if (!photograph) return tl::unexpected(photograph.error());
  KnownPhotograph known;
  known.decode_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  known.photograph = std::move(*photograph);
  known.settings.ball_diameter_m = scene.ball.diameter_m;
  known.settings.px_per_m = rendered->truth.px_per_m;
  known.settings.map = strobe::digitize::PlaneMap::plain(known.photograph.height());
  known.settings.flash_times_s = seen_flashes(rendered->truth);
  known.truth = true_images(scene, rendered->truth);
  for (const sim::ImageTruth& image : rendered->truth.images) known.times_s.push_back(image.time_s);
  return known;
}

}  // namespace strobe::bench::digitize
