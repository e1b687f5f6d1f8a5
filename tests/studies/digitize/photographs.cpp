#include "tests/studies/digitize/photographs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "common/image/opencv.hpp"
#include "sim/photograph/render.hpp"
#include "sim/rig/camera.hpp"
#include "tests/support/pictures.hpp"

namespace strobe::studies::digitize {

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

std::vector<TrueImage> true_images(const sim::Scene& scene, const sim::PhotographTruth& truth) {
  std::vector<TrueImage> images;
  for (const sim::ImageTruth& image : truth.images)
    images.push_back(
        {.leg = image.leg,
         .centre_px = image.centre_px,
         .diameter_px = image.diameter_px,
         .equator_rad = scene.ball_appearance.line ? std::optional(image.equator_rad) : std::nullopt,
         .equator_tilt_rad =
             scene.ball_appearance.line ? std::optional(image.equator_tilt_rad) : std::nullopt,
         .top_px = image.top_px,
         .contact_width_px = image.contact_width_px,
         .whole = image.whole});
  return images;
}

/// Of the balls that a fault throws besides the shot's.
std::vector<TrueImage> others_of(const Take& take, const sim::Exposure& exposure,
                                 const sim::Appearance& appearance) {
  std::vector<TrueImage> others;
  for (const sim::ThrownBall& ball : exposure.more_balls) {
    sim::Exposure other = exposure;
    other.ball = ball;
    const auto truth = sim::photograph_truth(take.scene, other, appearance,
                                             sim::lit_balls(take.scene, other, appearance));
    std::ranges::move(true_images(take.scene, truth), std::back_inserter(others));
  }
  return others;
}

std::vector<double> seen_flashes(const sim::PhotographTruth& truth) {
  std::vector<double> times_s;
  for (const auto& time_s : truth.flash_times_s)
    if (time_s) times_s.push_back(*time_s);
  return times_s;
}

/// Of pixels with blue first.
Result<Bytes> as_file(const cv::Mat& pixels, int jpeg_quality) {
  if (jpeg_quality == 0) return testing::encoded_picture(pixels, ".tif");
  cv::Mat bytes;
  pixels.convertTo(bytes, CV_8U, pixels.depth() == CV_16U ? 255.0 / 65535.0 : 1.0);
  if (bytes.channels() == 3) cv::cvtColor(bytes, bytes, cv::COLOR_BGR2RGB);
  return image::encode_jpeg(image::pixels_of(bytes), jpeg_quality);
}

/// Whole under its name or not there: several runs may share the folder.
Result<void> keep(const fs::path& path, const Bytes& bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  const fs::path part = path.string() + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(part, path, error);
  if (!file || error) return fail(path.string() + ": cannot be written");
  return {};
}

Result<Bytes> render_bytes(const Take& take, const sim::SimulatedShot& shot) {
  if (take.independent)
    return as_file(render_independently(take.scene, shot.exposure, take.seed, take.look),
                   take.jpeg_quality.value_or(85 + take.shot % 11));
  const auto rendered = sim::render(take.scene, take.seed, shot.exposure);
  if (!rendered) return tl::unexpected(rendered.error());
  return as_file(rendered->pixels, take.jpeg_quality.value_or(0));
}

fs::path kept_path(const Take& take) {
  std::string name = take.scene.name + (take.independent ? "_independent" : "");
  if (!take.shooting.train.empty()) {
    std::size_t hash = 0;
    for (const Duration offset : take.shooting.train)
      hash = hash * 31 + static_cast<std::size_t>(offset.count());
    name += fmt::format("_train{:x}", hash);
  }
  return take.kept_in /
         fmt::format("{}_seed{}_{:04}{}", name, take.seed, take.shot, take.independent ? ".jpg" : ".tif");
}

}  // namespace

Result<Bytes> photograph_bytes(const Take& take, const sim::SimulatedShot& shot) {
  if (take.kept_in.empty() || take.jpeg_quality) return render_bytes(take, shot);
  const fs::path path = kept_path(take);
  std::ifstream file(path, std::ios::binary);
  if (file) return Bytes(std::istreambuf_iterator<char>(file), {});
  auto bytes = render_bytes(take, shot);
  if (!bytes) return bytes;
  if (auto kept = keep(path, *bytes); !kept) return tl::unexpected(kept.error());
  return bytes;
}

namespace {

KnownPhotograph known_of(const Take& take, sim::SimulatedShot shot) {
  KnownPhotograph known;
  const sim::Appearance appearance = sim::draw_appearance(take.scene, take.seed, take.shot);
  known.scene_truth = sim::photograph_truth(take.scene, shot.exposure, appearance,
                                            sim::lit_balls(take.scene, shot.exposure, appearance));
  known.settings.ball_diameter_m = take.scene.ball.diameter_m;
  known.settings.line_drawn = take.scene.ball_appearance.line || take.ignore_marking;
  known.settings.px_per_m = known.scene_truth.px_per_m;
  known.settings.flash_times_s = seen_flashes(known.scene_truth);
  known.truth = true_images(take.scene, known.scene_truth);
  for (const sim::ImageTruth& image : known.scene_truth.images) known.times_s.push_back(image.time_s);
  known.others = others_of(take, shot.exposure, appearance);
  known.surface_px = known.scene_truth.surface_px;
  if (const auto& camera = take.scene.camera; camera.distance_m > 0.0) {
    const reduction::PointPx foot = sim::Camera(take.scene).foot_px();
    known.viewpoint_px = {foot.x, foot.y, camera.distance_m * camera.px_per_m};
  }
  known.shot = std::move(shot);
  return known;
}

Result<sim::SimulatedShot> simulated(const Take& take) {
  return sim::shoot(take.scene, take.seed, take.shot, sim::Model::full(), take.shooting);
}

}  // namespace

Result<KnownPhotograph> known_exposure(const Take& take) {
  auto shot = simulated(take);
  if (!shot) return tl::unexpected(shot.error());
  return known_of(take, std::move(*shot));
}

Result<KnownPhotograph> known_photograph(const Take& take) {
  auto shot = simulated(take);
  if (!shot) return tl::unexpected(shot.error());
  const auto bytes = photograph_bytes(take, *shot);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto start = std::chrono::steady_clock::now();
  auto photograph = strobe::digitize::decode_photograph(*bytes, take.scene.name);
  if (!photograph) return tl::unexpected(photograph.error());
  const double decode_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  KnownPhotograph known = known_of(take, std::move(*shot));
  if (take.independent) {
    IndependentTruth truth = independent_truth(take.scene, known.shot.exposure, take.seed, take.look);
    known.truth = std::move(truth.images);
    known.others = std::move(truth.others);
    known.times_s = std::move(truth.times_s);
    known.surface_px = std::move(truth.surface_px);
    known.viewpoint_px = truth.viewpoint_px;
  }
  known.decode_ms = decode_ms;
  known.photograph = std::move(*photograph);
  constexpr double kLight = 0.45;  // of the lightest felt in one image, at an exposure of 1
  add_distractors(take.distractors, take.seed * 7919 + static_cast<std::uint64_t>(take.shot),
                  kLight * take.scene.photograph.exposure, known.truth, known.photograph);
  known.settings.map = strobe::digitize::PlaneMap::uncalibrated(known.photograph.height());
  return known;
}

}  // namespace strobe::studies::digitize
