#include "sim/gev/pictures.hpp"

#include <cmath>

#include "sim/photograph/render.hpp"

namespace strobe::sim::gev {
namespace {

constexpr double kTop12 = 4095.0;
constexpr double kUsualExposure_s = 0.01;

int bits_of(PixelFormat format) {
  return format == PixelFormat::mono8 ? 8 : format == PixelFormat::mono16 ? 16 : 12;
}

/// The scene's sensor with the camera's settings. Gain multiplies electrons, their noise with them.
Scene with_settings(const Scene& scene, const PictureSettings& settings) {
  Scene set = scene;
  const double gain = std::pow(10.0, settings.gain_db / 20.0);
  set.photograph.bits = bits_of(settings.format);
  set.photograph.gamma = settings.gamma;
  set.photograph.exposure *= gain;
  set.photograph.ambient *= gain;
  set.photograph.full_well_e /= gain;
  set.photograph.black_level = settings.black_level_dn / kTop12;
  return set;
}

Packet bytes_of(const cv::Mat& pixels) {
  const std::size_t row = static_cast<std::size_t>(pixels.cols) * pixels.elemSize();
  Packet bytes;
  bytes.reserve(row * static_cast<std::size_t>(pixels.rows));
  for (int y = 0; y < pixels.rows; ++y) bytes.insert(bytes.end(), pixels.ptr(y), pixels.ptr(y) + row);
  return bytes;
}

}  // namespace

PictureSettings picture_settings(const Device& device) {
  return {device.pixel_format(), 1e-6 * device.number(camera::kExposureTime), device.number(camera::kGain),
          device.number(camera::kBlackLevel),
          device.word(camera::kGammaEnable) != 0 ? device.number(camera::kGamma) : 1.0};
}

Result<Packet> shot_pixels(const Scene& scene, std::uint64_t seed, const Exposure& exposure,
                           const PictureSettings& settings) {
  return render(with_settings(scene, settings), seed, exposure).map([](const Photograph& photograph) {
    return bytes_of(photograph.pixels);
  });
}

Result<Packet> room_pixels(const Scene& scene, std::uint64_t seed, const PictureSettings& settings) {
  const Duration before_touchdown = milliseconds(5);
  const MonoTime instant = MonoTime{} + milliseconds(100);
  auto path = BallPath::make(scene, draw_shot_conditions(without_spread(scene), seed, 1));
  if (!path) return tl::unexpected(path.error());
  Exposure exposure;
  exposure.shot = 1;
  exposure.line_on = exposure.opened = MonoTime{};
  exposure.closed = instant + milliseconds(100);
  exposure.ball = ThrownBall{std::move(*path), instant + before_touchdown};
  Pulse pulse;
  pulse.edge = instant;
  pulse.flashes = {instant, instant};
  pulse.lamps = {1, 1};
  exposure.pulses.push_back(std::move(pulse));
  Scene lit = scene;
  lit.faults.clear();
  lit.photograph.exposure *= settings.exposure_s / kUsualExposure_s;
  lit.lamps.flash_s = 0.0;
  return shot_pixels(lit, seed, exposure, settings);
}

}  // namespace strobe::sim::gev
