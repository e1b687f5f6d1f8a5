#include "tests/studies/digitize/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/units/angles.hpp"

namespace strobe::studies::digitize {

namespace {

using reduction::BallImage;
using reduction::Leg;

const char* leg_name(Leg leg) {
  return leg == Leg::incoming ? "incoming" : leg == Leg::contact ? "contact" : "rebound";
}

/// How many other true images reach into this one.
int overlaps(const std::vector<TrueImage>& truth, std::size_t i) {
  return static_cast<int>(std::ranges::count_if(
             truth,
             [&](const TrueImage& other) {
               return std::hypot(other.centre_px.x - truth[i].centre_px.x,
                                 other.centre_px.y - truth[i].centre_px.y) < truth[i].diameter_px;
             })) -
         1;
}

std::string field(std::optional<double> value) {
  return value && std::isfinite(*value) ? fmt::format("{:.5g}", *value) : std::string();
}

std::string measured_fields(const TrueImage& truth, const BallImage& image) {
  const auto& c = image.centre_cov_px2;
  const auto sd = [&](std::size_t k) { return c ? std::optional(std::sqrt((*c)[k])) : std::nullopt; };
  std::optional<double> equator_deg, equator_sd_deg, top_px, width_px;
  if (truth.equator_rad && image.equator_rad)
    equator_deg = degrees(wrap_half_turn(*image.equator_rad - *truth.equator_rad));
  if (image.equator_sd_rad) equator_sd_deg = degrees(*image.equator_sd_rad);
  if (truth.top_px && image.top_px && truth.leg == Leg::contact) top_px = image.top_px->y - truth.top_px->y;
  if (truth.contact_width_px && image.contact_width_px)
    width_px = *image.contact_width_px - *truth.contact_width_px;
  const bool round = truth.leg != Leg::contact;
  return fmt::format("{},{},{},{},{},{},{},{},{},{}", field(image.centre_px.x - truth.centre_px.x),
                     field(image.centre_px.y - truth.centre_px.y), field(sd(0)), field(sd(3)),
                     field(round ? std::optional(image.diameter_px - truth.diameter_px) : std::nullopt),
                     field(image.diameter_sd_px), field(equator_deg), field(equator_sd_deg), field(top_px),
                     field(width_px));
}

}  // namespace

double centre_rms_px(const Score& s) {
  return std::sqrt(0.5 * (s.x_px.squares + s.y_px.squares) / s.x_px.count);
}

void print_score_head(int name_width) {
  fmt::print(
      "{:<{}} {:>11} {:>5} {:>8} {:>8} {:>4} | {:>6} {:>5} {:>6} | {:>6} {:>5} {:>6} | {:>11} {:>5} {:>6} "
      "{:>5} {:>6} {:>5} | {:>6} {:>5} {:>6} | {:>6} {:>6} | {:>6} {:>5} | {:>5}\n",
      "", name_width, "airborne", "said", "contact", "invented", "cut", "centre", "norm.", "worst", "diam.",
      "norm.", "worst", "equators", "said", "deg", "norm.", "worst", "false", "tilt", "norm.", "bias", "top px", "width", "surf.", "norm.",
      ">5 sd");
}

void print_score(const std::string& name, int name_width, const Score& s) {
  fmt::print(
      "{:<{}} {:>5}/{:<5} {:>5} {:>4}/{:<3} {:>8} {:>4} | {:>6.3f} {:>5.2f} {:>6.2f} | {:>6.3f} {:>5.2f} "
      "{:>6.2f} | {:>5}/{:<5} {:>5} {:>6.3f} {:>5.2f} {:>6.2f} {:>5} | {:>6.3f} {:>5.2f} {:>6.3f} | {:>6.2f} "
      "{:>6.2f} | {:>6.3f} {:>5.2f} | "
      "{:>5}\n",
      name, name_width, s.found, s.airborne, s.reported, s.contact_found, s.contact, s.invented, s.cut,
      centre_rms_px(s), s.mahalanobis.normalized(), std::max(s.x_px.largest, s.y_px.largest),
      s.diameter_px.rms(), s.diameter_px.normalized(), s.diameter_px.largest, s.lines_found, s.lines,
      s.lines_reported, degrees(s.equator_rad.rms()), s.equator_rad.normalized(),
      degrees(s.equator_rad.largest), s.lines_invented, degrees(s.tilt_rad.rms()), s.tilt_rad.normalized(),
      degrees(s.tilt_rad.bias()), s.top_px.rms(), s.contact_width_px.rms(), s.surface_px.rms(),
      s.surface_px.normalized(), s.wild());
  std::fflush(stdout);
}

std::string score_csv_head() {
  return "airborne,found,reported,contact,contact_found,invented,cut,centre_px,centre_normalized,diameter_px,"
         "diameter_normalized,lines,lines_found,lines_reported,equator_deg,equator_normalized,tilt_deg,tilt_"
         "normalized,tilt_bias_deg,top_px,surface_px,surface_normalized,wild";
}

std::string score_csv(const Score& s) {
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", s.airborne, s.found,
                     s.reported, s.contact, s.contact_found, s.invented, s.cut, field(centre_rms_px(s)),
                     field(s.mahalanobis.normalized()), field(s.diameter_px.rms()),
                     field(s.diameter_px.normalized()), s.lines, s.lines_found, s.lines_reported,
                     field(degrees(s.equator_rad.rms())), field(s.equator_rad.normalized()),
                     field(degrees(s.tilt_rad.rms())), field(s.tilt_rad.normalized()),
                     field(degrees(s.tilt_rad.bias())), field(s.top_px.rms()), field(s.surface_px.rms()), field(s.surface_px.normalized()),
                     s.wild());
}

std::string image_csv_head() {
  return "scene,shot,state,leg,whole,overlaps,x_px,y_px,dx_px,dy_px,sd_x_px,sd_y_px,ddiameter_px,sd_diameter_"
         "px,dequator_deg,sd_equator_deg,dtop_px,dwidth_px\n";
}

std::string image_csv(const std::string& name, int shot, const KnownPhotograph& known,
                      const strobe::digitize::Digitization& digitization) {
  const auto& images = digitization.frame.images;
  std::vector<const BallImage*> of(known.truth.size(), nullptr);
  std::vector<char> taken(images.size(), 0);
  for (const Pair& pair : pairs_of(known.truth, images)) {
    of[pair.truth] = &images[pair.image];
    taken[pair.image] = 1;
  }
  std::string text;
  for (std::size_t i = 0; i < known.truth.size(); ++i) {
    const TrueImage& truth = known.truth[i];
    text += fmt::format("{},{},{},{},{},{},{:.2f},{:.2f},{}\n", name, shot, of[i] ? "found" : "missed",
                        leg_name(truth.leg), truth.whole ? 1 : 0, overlaps(known.truth, i), truth.centre_px.x,
                        truth.centre_px.y, of[i] ? measured_fields(truth, *of[i]) : ",,,,,,,,,");
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (taken[i] == 0)
      text += fmt::format("{},{},invented,,,,{:.2f},{:.2f},,,,,,,,,,\n", name, shot, images[i].centre_px.x,
                          images[i].centre_px.y);
  }
  return text;
}

std::vector<ReportedPlace> reported_places(const strobe::digitize::Digitization& digitization) {
  std::vector<ReportedPlace> places;
  for (const strobe::digitize::Unmeasured& u : digitization.unmeasured)
    places.push_back({{u.centre.x, u.centre.y}, u.what});
  return places;
}

}  // namespace strobe::studies::digitize
