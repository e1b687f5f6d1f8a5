#include "sim/photograph/render.hpp"

#include <fmt/format.h>

#include "sim/photograph/background.hpp"
#include "sim/photograph/ball_light.hpp"
#include "sim/photograph/lit_balls.hpp"
#include "sim/photograph/sensor.hpp"

namespace strobe::sim {

namespace {

/// Light of the lightest felt in one image, at an exposure of 1, over what saturates.
constexpr double kUsualLight = 0.45;

void add_balls(const Scene& scene, const Appearance& appearance, const std::vector<BallImageOnSensor>& images,
               const std::array<double, 2>& light_of_all, const cv::Mat& behind, cv::Mat& light) {
  const BallLight painter(scene, appearance);
  const double all = light_of_all[0] + light_of_all[1];
  cv::parallel_for_({0, light.rows}, [&](const cv::Range& rows) {
    for (const BallImageOnSensor& image : images) {
      for (const LitBall& ball : image.balls)
        painter.add(ball, behind, (ball.light[0] + ball.light[1]) / all, rows.start, rows.end, light);
    }
  });
}

}  // namespace

Result<Photograph> render(const Scene& scene, const Exposure& exposure, const Appearance& appearance) {
  const SensorSize size = sensor_size(scene);
  if (static_cast<double>(size.width) * size.height > kMaxPixels)
    return fail(
        fmt::format("photograph: {} x {} px are more than {:.0f} megapixels; width_px and height_px "
                    "of [photograph] make it smaller",
                    size.width, size.height, 1e-6 * kMaxPixels));
  const std::vector<BallImageOnSensor> images = lit_balls(scene, exposure, appearance);
  const std::array<double, 2> all = light_of_all(exposure, appearance, scene.photograph.flash_power_sd);
  cv::Mat light(size.height, size.width, CV_32FC1, cv::Scalar(0.0));
  if (all[0] + all[1] > 0.0) {
    cv::Mat behind = render_background(scene, appearance, images, all);
    if (scene.background.flashes > 0) behind *= (all[0] + all[1]) / (2.0 * scene.background.flashes);
    behind.copyTo(light);
    add_balls(scene, appearance, images, all, behind, light);
    add_balls(scene, appearance, more_lit_balls(scene, exposure, appearance), all, behind, light);
  }
  light = light * (kUsualLight * scene.photograph.exposure) + scene.photograph.ambient;
  blur(light, appearance.blur_px, scene.photograph.defocus_px);
  Photograph photograph;
  photograph.pixels = develop(light, scene.photograph, appearance);
  photograph.truth = photograph_truth(scene, exposure, appearance, images);
  return photograph;
}

Result<Photograph> render(const Scene& scene, std::uint64_t seed, const Exposure& exposure) {
  return render(scene, exposure, draw_appearance(scene, seed, exposure.shot));
}

}  // namespace strobe::sim
