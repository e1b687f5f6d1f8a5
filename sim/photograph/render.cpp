#include "sim/photograph/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"
#include "sim/photograph/background.hpp"
#include "sim/photograph/ball_surface.hpp"
#include "sim/photograph/colours.hpp"
#include "sim/photograph/dng.hpp"
#include "sim/photograph/lit_balls.hpp"
#include "sim/random/draws.hpp"

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

constexpr int kTable = 4096;
constexpr int kDiscGrid = 8;

/// Normal numbers from 24 bits: the sum of two quantiles, each of a table. Reaches 5.2 sd.
class NormalTable {
 public:
  NormalTable() {
    // Quantiles by bisection of erfc; once in a program.
    for (int i = 0; i < kTable; ++i) {
      const double p = (i + 0.5) / kTable;
      double low = -6.0, high = 6.0;
      for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle * std::numbers::sqrt2 / 2.0) < p ? low : high) = middle;
      }
      values_[static_cast<std::size_t>(i)] = static_cast<float>(0.5 * (low + high) / std::numbers::sqrt2);
    }
  }
  float operator()(std::uint64_t bits) const {
    return values_[bits & (kTable - 1)] + values_[(bits >> 12) & (kTable - 1)];
  }

 private:
  std::array<float, kTable> values_{};
};

cv::Mat disc(double radius_px) {
  const int half = static_cast<int>(std::ceil(radius_px));
  cv::Mat kernel(2 * half + 1, 2 * half + 1, CV_32FC1, cv::Scalar(0.0));
  for (int j = -half * kDiscGrid - kDiscGrid / 2; j < half * kDiscGrid + kDiscGrid / 2; ++j) {
    for (int i = -half * kDiscGrid - kDiscGrid / 2; i < half * kDiscGrid + kDiscGrid / 2; ++i) {
      const double x = (i + 0.5) / kDiscGrid, y = (j + 0.5) / kDiscGrid;
      if (x * x + y * y > radius_px * radius_px) continue;
      kernel.at<float>(cvRound(y) + half, cvRound(x) + half) += 1.0F;
    }
  }
  return kernel / cv::sum(kernel)[0];
}

/// Numbers of one row.
template <typename Number>
void develop_row(const float* light, Number* numbers, int row, int width, int height,
                 const PhotographSettings& s, const Appearance& appearance) {
  static const NormalTable normal;
  const auto top = static_cast<float>((1 << s.bits) - 1);
  const auto per_electron = static_cast<float>(1.0 / s.full_well_e);
  const auto read = static_cast<float>(s.read_noise_e * s.read_noise_e * per_electron * per_electron);
  const auto black = static_cast<float>(s.black_level);
  const double half2 = 0.25 * (static_cast<double>(width) * width + static_cast<double>(height) * height);
  const double dy = row - 0.5 * (height - 1);
  const std::uint64_t key =
      hash64(appearance.noise + 0x51ULL) + static_cast<std::uint64_t>(row) * 0x9e3779b97f4a7c15U;
  for (int i = 0; i < width; ++i) {
    const double dx = i - 0.5 * (width - 1);
    const auto vignette = static_cast<float>(1.0 - appearance.vignetting * (dx * dx + dy * dy) / half2);
    const float seen = std::max(0.0F, vignette * light[i]);
    const std::uint64_t bits = hash64(key + static_cast<std::uint64_t>(i) * 0xd1342543de82ef95U);
    float value = seen + normal(bits) * std::sqrt(seen * per_electron + read) + black;
    value = std::clamp(value, 0.0F, 1.0F);
    if (s.gamma != 1.0) value = std::pow(value, static_cast<float>(s.gamma));
    numbers[i] = static_cast<Number>(value * top + 0.5F);
  }
}

Result<std::vector<std::uint8_t>> encode(const cv::Mat& pixels, PhotographFormat format,
                                         const std::optional<image::Mosaic>& mosaic) {
  const bool known = pixels.type() == CV_8UC1 || pixels.type() == CV_16UC1;
  if (!known) return fail("cannot be encoded");
  const image::Pixels grey = image::pixels_of(pixels);
  if (is_mosaic(format) && (!mosaic || pixels.type() != CV_16UC1)) return fail("is no mosaic");
  if (format == PhotographFormat::dng) return encode_dng(grey, *mosaic);
  if (format == PhotographFormat::mosaic) return image::encode_tiff(grey, {.mosaic = mosaic});
  return format == PhotographFormat::png ? image::encode_png(grey) : image::encode_tiff(grey);
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
  const auto exposed = [&](cv::Mat& of, double ambient) {
    of = of * (kUsualLight * scene.photograph.exposure) + ambient;
    blur(of, appearance.blur_px, scene.photograph.defocus_px);
  };
  Photograph photograph;
  if (is_mosaic(scene.photograph.format)) {
    cv::Mat balls(light.size(), CV_32FC1, cv::Scalar(0.0));
    const cv::Mat nothing(light.size(), CV_32FC1, cv::Scalar(0.0));
    if (all[0] + all[1] > 0.0) {
      add_balls(scene, appearance, images, all, nothing, balls);
      add_balls(scene, appearance, more_lit_balls(scene, exposure, appearance), all, nothing, balls);
    }
    light -= balls;
    exposed(balls, 0.0);
    exposed(light, scene.photograph.ambient);
    photograph.mosaic = mosaic_of(scene.photograph);
    colour_pixels(*photograph.mosaic, ball_colour(scene.ball_appearance.surface), balls, light);
  } else {
    exposed(light, scene.photograph.ambient);
  }
  photograph.pixels = develop(light, scene.photograph, appearance);
  photograph.truth = photograph_truth(scene, exposure, appearance, images);
  return photograph;
}

Result<Photograph> render(const Scene& scene, std::uint64_t seed, const Exposure& exposure) {
  return render(scene, exposure, draw_appearance(scene, seed, exposure.shot));
}

void blur(cv::Mat& light, double blur_px, double defocus_px) {
  if (defocus_px > 0.0) cv::filter2D(light, light, -1, disc(defocus_px), {-1, -1}, 0.0, cv::BORDER_REPLICATE);
  if (blur_px <= 0.0) return;
  const int side = 2 * static_cast<int>(std::ceil(3.5 * blur_px)) + 1;
  cv::GaussianBlur(light, light, {side, side}, blur_px, blur_px, cv::BORDER_REPLICATE);
}

cv::Mat develop(const cv::Mat& light, const PhotographSettings& settings, const Appearance& appearance) {
  cv::Mat numbers(light.size(), settings.bits == 8 ? CV_8UC1 : CV_16UC1);
  cv::parallel_for_({0, light.rows}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      if (settings.bits == 8)
        develop_row(light.ptr<float>(row), numbers.ptr<std::uint8_t>(row), row, light.cols, light.rows,
                    settings, appearance);
      else
        develop_row(light.ptr<float>(row), numbers.ptr<std::uint16_t>(row), row, light.cols, light.rows,
                    settings, appearance);
    }
  });
  return numbers;
}

std::string extension(PhotographFormat format) {
  return format == PhotographFormat::png ? ".png" : format == PhotographFormat::dng ? ".dng" : ".tif";
}

Result<void> write_photograph(const std::filesystem::path& path, const cv::Mat& pixels,
                              PhotographFormat format, std::optional<WallTime> written,
                              const std::optional<image::Mosaic>& mosaic) {
  const auto bytes = encode(pixels, format, mosaic);
  if (!bytes) return fail(path.string() + ": " + bytes.error().message);
  const std::filesystem::path part = path.string() + ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(bytes->size()));
  file.close();
  std::error_code error;
  if (written) std::filesystem::last_write_time(part, std::chrono::file_clock::from_sys(*written), error);
  if (file && !error) std::filesystem::rename(part, path, error);
  if (file && !error) return {};
  std::filesystem::remove(part, error);
  return fail(path.string() + ": cannot be written");
}

}  // namespace strobe::sim
