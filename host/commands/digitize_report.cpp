#include "host/commands/digitize_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/units/angles.hpp"
#include "host/text/text.hpp"

namespace strobe::host {

namespace {

using digitize::DigitizeSettings;
using reduction::BallImage;
using reduction::Leg;

std::string_view leg_name(const BallImage& image) {
  if (image.other_leg) return "other";
  return image.leg ? name(*image.leg) : "";
}

std::string with_sd(double value, const std::optional<double>& sd, std::size_t width) {
  if (!sd) return right(rounded(value, 0.0, 1), width) + left("", 9);
  return right(rounded(value, *sd, 1), width) + " ± " + left(fmt::format("{:.2g}", *sd), 6);
}

std::optional<double> centre_sd(const BallImage& image, std::size_t axis) {
  if (!image.centre_cov_px2) return std::nullopt;
  return std::sqrt((*image.centre_cov_px2)[axis == 0 ? 0 : 3]);
}

std::string image_line(const BallImage& image, std::size_t index) {
  std::string line = right(fmt::format("{}", index + 1), 3) + "  " + left(leg_name(image), 9);
  line += std::isfinite(image.time_s) ? right(fmt::format("{:.4f}", image.time_s * 1e3), 10) : right("-", 10);
  line += with_sd(image.centre_px.x, centre_sd(image, 0), 11) +
          with_sd(image.centre_px.y, centre_sd(image, 1), 11);
  line +=
      image.diameter_px > 0.0 ? with_sd(image.diameter_px, image.diameter_sd_px, 10) : left("         -", 19);
  if (image.equator_rad) {
    auto sd_deg = image.equator_sd_rad;
    if (sd_deg) *sd_deg = degrees(*sd_deg);
    line += with_sd(degrees(*image.equator_rad), sd_deg, 9);
  } else {
    line += left("        -", 18);
  }
  return line + (image.source == "hand" ? " hand" : "");
}

std::vector<std::string> surface_lines(const digitize::Digitization& digitization) {
  std::vector<std::string> lines;
  const auto& points = digitization.frame.surface_px;
  if (points.size() >= 2) {
    const auto& a = points.front();
    const auto& b = points.back();
    lines.push_back(fmt::format("surface: ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) px, {:.3f} degrees", a.x, a.y,
                                b.x, b.y, degrees(std::atan2(b.y - a.y, b.x - a.x))));
    if (digitization.frame.surface_sd_px)
      lines.back() += fmt::format(", sd {:.2g} px", *digitization.frame.surface_sd_px);
  } else if (digitization.no_surface) {
    lines.push_back(fmt::format("no surface line ({}): {}", digitize::name(digitization.no_surface->reason),
                                digitization.no_surface->detail));
  }
  return lines;
}

std::vector<std::string> scale_lines(const digitize::Digitization& digitization,
                                     const DigitizeSettings& settings) {
  std::vector<std::string> lines;
  if (settings.px_per_m)
    lines.push_back(fmt::format("scale: {} px/m{}", *settings.px_per_m,
                                settings.px_per_m_sd
                                    ? fmt::format(" ± {:.2g}, calibrated", *settings.px_per_m_sd)
                                    : ", a start only: speeds will be read by the ball's diameter"));
  if (const auto& found = digitization.scale)
    lines.push_back(fmt::format("by the ball's {} m on {} image{}: {} ± {:.2g} px/m",
                                settings.ball_diameter_m, found->images, found->images == 1 ? "" : "s",
                                rounded(found->px_per_m, found->px_per_m_sd, 1), found->px_per_m_sd));
  return lines;
}

}  // namespace

std::vector<std::string> digitization_lines(const digitize::Digitization& digitization,
                                            const std::string& photograph, const DigitizeSettings& settings) {
  const auto& images = digitization.frame.images;
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("{}: {} image{} of the ball", photograph, images.size(), images.size() == 1 ? "" : "s"));
  if (!images.empty()) {
    lines.push_back(
        "  #  leg         time ms       x px              y px              diameter px        equator deg");
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    lines.push_back(image_line(images[i], i));
    if (images[i].top_px) {
      lines.push_back(fmt::format("     top ({:.2f}, {:.2f}) px", images[i].top_px->x, images[i].top_px->y));
      if (images[i].contact_width_px)
        lines.back() += fmt::format(", flat over {:.1f} px", *images[i].contact_width_px);
    }
  }
  for (std::string& line : surface_lines(digitization)) lines.push_back(std::move(line));
  for (std::string& line : scale_lines(digitization, settings)) lines.push_back(std::move(line));
  for (const std::string& remark : digitization.remarks) lines.push_back("note: " + remark);
  return lines;
}

std::vector<std::string> unmeasured_lines(const digitize::Digitization& digitization) {
  std::vector<std::string> lines;
  for (const auto& u : digitization.unmeasured) {
    lines.push_back(fmt::format("no {} at ({:.1f}, {:.1f}), {:.0f} px wide: {}{}{}", u.what, u.centre.x,
                                u.centre.y, u.diameter, digitize::name(u.why.reason),
                                u.why.detail.empty() ? "" : ": ", u.why.detail));
  }
  return lines;
}

std::string stages_line(const digitize::Digitization& digitization) {
  std::string line = "strobe: digitize: took";
  double total_ms = 0.0;
  for (const auto& [stage, ms] : digitization.stage_ms) {
    line += fmt::format(" {} {:.1f} ms,", stage, ms);
    total_ms += ms;
  }
  return line + fmt::format(" together {:.1f} ms\n", total_ms);
}

}  // namespace strobe::host
