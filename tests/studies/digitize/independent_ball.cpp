#include "tests/studies/digitize/independent_ball.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::studies::digitize {

namespace {

double hashed(std::uint64_t seed, int x, int y, int z) {
  std::uint64_t h = seed;
  for (const int part : {x, y, z}) {
    h ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(part)) + 0x9e3779b97f4a7c15ULL + (h << 6) +
         (h >> 2);
    h *= 0xff51afd7ed558ccdULL;
    h ^= h >> 33;
  }
  return static_cast<double>(h >> 11) * 0x1p-53;
}

double smooth(double t) { return t * t * (3.0 - 2.0 * t); }

/// Oren and Nayar (1994), the qualitative model.
double rough_reflection(double roughness, const cv::Vec3d& n, const cv::Vec3d& in, const cv::Vec3d& out) {
  const double cos_in = n.dot(in), cos_out = std::max(n.dot(out), 1e-3);
  if (cos_in <= 0.0) return 0.0;
  const double s2 = roughness * roughness;
  const double a = 1.0 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
  const cv::Vec3d in_flat = in - n * cos_in, out_flat = out - n * cos_out;
  const double across = in_flat.dot(out_flat) / std::max(cv::norm(in_flat) * cv::norm(out_flat), 1e-9);
  const double sin_in = std::sqrt(std::max(0.0, 1.0 - cos_in * cos_in));
  const double sin_out = std::sqrt(std::max(0.0, 1.0 - cos_out * cos_out));
  // The larger angle's sine, the smaller one's tangent.
  const double steep = cos_in < cos_out ? sin_in * sin_out / cos_out : sin_out * sin_in / cos_in;
  return cos_in * (a + b * std::max(0.0, across) * steep);
}

double albedo(const FeltLook& look, double radius_m, const cv::Vec3d& own) {
  constexpr double kFibre_m = 0.0009, kClump_m = 0.004;
  const cv::Vec3d at = own * radius_m;
  double value = 1.0 + look.grain * (1.8 * (value_noise(look.texture, at * (1.0 / kFibre_m)) - 0.5) +
                                     1.8 * (value_noise(look.texture + 1, at * (1.0 / kClump_m)) - 0.5));
  // Two small circles stand for the seam.
  const double seam = std::min(std::abs(own[0] - 0.55), std::abs(own[2] + 0.35)) * radius_m / 0.0015;
  value *= 1.0 - look.seam * std::exp(-seam * seam);
  if (!look.line) return value;
  const double off_m =
      radius_m * std::abs(std::cos(look.line_tilt_rad) * own[1] + std::sin(look.line_tilt_rad) * own[2]);
  constexpr double kInkEdge_m = 0.00025;
  return value *
         (1.0 - look.line_contrast / (1.0 + std::exp((off_m - 0.5 * look.line_width_m) / kInkEdge_m)));
}

}  // namespace

double value_noise(std::uint64_t seed, const cv::Vec3d& at) {
  const int x = static_cast<int>(std::floor(at[0])), y = static_cast<int>(std::floor(at[1])),
            z = static_cast<int>(std::floor(at[2]));
  const double u = smooth(at[0] - x), v = smooth(at[1] - y), w = smooth(at[2] - z);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    sum += (i ? u : 1.0 - u) * (j ? v : 1.0 - v) * (k ? w : 1.0 - w) * hashed(seed, x + i, y + j, z + k);
  }
  return sum;
}

double felt_light(const FeltLook& look, const FeltBall& ball, const std::array<cv::Vec3d, 2>& lamps,
                  const cv::Vec3d& normal, const cv::Vec3d& to_lens) {
  const double c = std::cos(ball.equator_rad), s = std::sin(ball.equator_rad);
  const cv::Vec3d own(c * normal[0] + s * normal[1], c * normal[1] - s * normal[0], normal[2]);
  const cv::Vec3d at = ball.centre + normal * ball.radius_m;
  double light = 0.0;
  for (std::size_t lamp = 0; lamp < lamps.size(); ++lamp) {
    if (!(ball.light[lamp] > 0.0)) continue;
    const cv::Vec3d way = lamps[lamp] - at;
    const double away2 = way.dot(way), usual2 = lamps[lamp].dot(lamps[lamp]);
    light += ball.light[lamp] * usual2 / away2 *
             rough_reflection(look.roughness, normal, way * (1.0 / std::sqrt(away2)), to_lens);
  }
  return light * albedo(look, ball.radius_m, own);
}

double limb_waver(const FeltLook& look, const FeltBall& ball, double angle_rad) {
  double sum = 0.0;
  for (const int waves : {7, 19, 43}) {
    const double phase = 6.283 * hashed(look.texture, waves, 0, 0);
    sum += std::sin(waves * (angle_rad - ball.equator_rad) + phase);
  }
  return look.hairs_px * sum / std::sqrt(1.5);
}

}  // namespace strobe::studies::digitize
