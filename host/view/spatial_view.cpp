#include "host/view/spatial_view.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/figures/svg.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

using reduction::DerivedNumber;
using reduction::Flag;
using reduction::Readout;
using reduction::Spatial;
using Of = reduction::SpatialQuantity;

struct Moment {
  std::string_view words;
  Of omega_x, omega_y, omega_z, tilt, vz;
};
constexpr Moment kMoments[]{{"at touchdown", Of::omega_x_td_radps, Of::omega_y_td_radps, Of::omega_z_td_radps,
                             Of::spin_axis_tilt_td_deg, Of::vz_td_mps},
                            {"at lift-off", Of::omega_x_lo_radps, Of::omega_y_lo_radps, Of::omega_z_lo_radps,
                             Of::spin_axis_tilt_lo_deg, Of::vz_lo_mps}};

double sd_of(const DerivedNumber& number) { return std::hypot(number.sd, number.sd_systematic); }

bool is_off_zero(const std::optional<DerivedNumber>& number, double sds) {
  return number && std::abs(number->value) > sds * sd_of(*number);
}

bool is_tilted_then(const Readout& readout, const Moment& at) {
  const auto& tilt = (*readout.spatial)[at.tilt];
  return is_off_zero(tilt, 2.0) && (readout.flags.has(Flag::axis_tilted) || tilt->value > 1.0);
}

bool leaves_plane(const Readout& readout) {
  const Spatial& spatial = *readout.spatial;
  return readout.flags.has(Flag::out_of_plane) || is_off_zero(spatial[Of::vz_td_mps], 3.0) ||
         is_off_zero(spatial[Of::vz_lo_mps], 3.0);
}

std::string omega_words(const Spatial& spatial, const Moment& at) {
  return fmt::format("omega (x, y, z) ({}, {}, {}) rad/s", value_and_sd(spatial[at.omega_x]),
                     value_and_sd(spatial[at.omega_y]), value_and_sd(spatial[at.omega_z]));
}

figures::SpinningBall ball_at(const Spatial& spatial, const Moment& at) {
  figures::SpinningBall ball;
  ball.lines = {std::string(at.words), "axis " + value_and_sd(spatial[at.tilt]) + "° off the camera's"};
  const std::pair<const char*, Of> axes[]{{"x", at.omega_x}, {"y", at.omega_y}, {"z", at.omega_z}};
  for (std::size_t i = 0; i < std::size(axes); ++i) {
    const auto& omega = spatial[axes[i].second];
    ball.spin[i] = omega ? omega->value : 0.0;
    ball.lines.push_back(fmt::format("omega {} {} rad/s", axes[i].first, value_and_sd(omega)));
  }
  if (spatial[at.vz]) ball.lines.push_back("vz " + value_and_sd(spatial[at.vz]) + " m/s to the camera");
  return ball;
}

}  // namespace

std::string value_and_sd(const std::optional<DerivedNumber>& number) {
  if (!number) return "-";
  const double sd = sd_of(*number);
  return rounded(number->value, sd) + " ± " + rounded(sd, sd);
}

bool is_axis_tilted(const Readout& readout) {
  return readout.spatial && (is_tilted_then(readout, kMoments[0]) || is_tilted_then(readout, kMoments[1]));
}

std::vector<std::string> spatial_words(const Readout& readout) {
  std::vector<std::string> sentences;
  if (!readout.spatial) return sentences;
  const Spatial& spatial = *readout.spatial;
  const auto both = [&](std::string begin, Of Moment::*which, const auto& words) {
    std::string separator = " ";
    for (const Moment& at : kMoments) {
      if (!spatial[at.*which]) continue;
      begin += separator + words(at) + " " + std::string(at.words);
      separator = "; ";
    }
    return begin;
  };
  if (is_axis_tilted(readout))
    sentences.push_back(both("spin axis", &Moment::tilt, [&](const Moment& at) {
      return value_and_sd(spatial[at.tilt]) + " deg off the camera's, " + omega_words(spatial, at);
    }));
  if (leaves_plane(readout)) {
    sentences.push_back(both("towards the camera", &Moment::vz,
                             [&](const Moment& at) { return value_and_sd(spatial[at.vz]) + " m/s"; }));
    if (spatial[Of::off_plane_mm])
      sentences.back() += "; " + value_and_sd(spatial[Of::off_plane_mm]) + " mm before the calibrated plane";
  }
  return sentences;
}

std::string spin_drawing(const Readout& readout) {
  if (!is_axis_tilted(readout)) return {};
  std::vector<figures::SpinningBall> balls;
  for (const Moment& at : kMoments)
    if ((*readout.spatial)[at.tilt]) balls.push_back(ball_at(*readout.spatial, at));
  return figures::balls_svg("Spin axis as the camera sees it", balls);
}

}  // namespace strobe::host
