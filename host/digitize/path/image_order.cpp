#include "host/digitize/path/image_order.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/flight/parabola.hpp"
#include "common/units/angles.hpp"
#include "host/digitize/path/time_order.hpp"

namespace strobe::digitize {
namespace {

using reduction::BallImage;
using reduction::Frame;
using reduction::Leg;

std::optional<SurfaceLine> line_of(const Frame& frame) {
  if (frame.surface_px.size() < 2) return std::nullopt;
  SurfaceLine line;
  line.sd_px = frame.surface_sd_px.value_or(0.0);
  for (const auto& p : frame.surface_px) line.points.emplace_back(p.x, p.y);
  return line;
}

/// Images added by hand are kept whether or not they lie on the path.
void assign_outliers(Path& path, std::span<const PathPoint> points, const PathContext& context) {
  for (const Path::Outlier& outlier : path.outliers) {
    const PathPoint& p = points[static_cast<std::size_t>(outlier.index)];
    if (touches(p.at.y, p.sd_px, context)) {
      path.contact.push_back(outlier.index);
      continue;
    }
    std::vector<int>* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (auto& leg : path.legs) {
      for (const int i : leg) {
        const double distance = cv::norm(points[static_cast<std::size_t>(i)].at - p.at);
        if (distance >= least) continue;
        least = distance;
        nearest = &leg;
      }
    }
    if (nearest == nullptr) nearest = &path.legs.emplace_back();
    nearest->push_back(outlier.index);
  }
  const auto at = [&](int i) { return points[static_cast<std::size_t>(i)].at; };
  for (std::size_t k = 0; k < path.legs.size(); ++k) {
    // Along the path: from left to right, or down and up again.
    const auto place = [&](int i) { return path.curved ? at(i).x : k == 0 ? -at(i).y : at(i).y; };
    std::ranges::stable_sort(path.legs[k], {}, place);
  }
  std::ranges::stable_sort(path.contact, {}, [&](int i) { return at(i).x; });
  path.outliers.clear();
}

template <typename T>
std::vector<T> permuted(std::vector<T>& values, const std::vector<int>& sequence) {
  std::vector<T> result;
  result.reserve(values.size());
  for (const int i : sequence) result.push_back(std::move(values[static_cast<std::size_t>(i)]));
  return result;
}

void set_legs_and_times(const TimeOrder& order, const OrderSettings& settings, Frame& frame) {
  for (std::size_t k = 0; k < frame.images.size(); ++k) {
    BallImage& image = frame.images[k];
    image.other_leg = order.other_leg[k];
    if (!image.leg && !image.other_leg) image.leg = order.leg[k];
    image.time_s = std::numeric_limits<double>::quiet_NaN();
    image.flash_index.reset();
    if (order.flash.empty() || order.flash[k] < 0) continue;
    image.flash_index = order.flash[k];
    image.time_s = settings.flash_times_s[static_cast<std::size_t>(order.flash[k])];
  }
}

}  // namespace

void order_images(Frame& frame, std::vector<Outline>& outlines, const OrderSettings& settings,
                  std::vector<std::string>& remarks) {
  if (outlines.size() != frame.images.size() || outlines.empty()) return;
  const auto surface = line_of(frame);
  const auto points = path_points(outlines, surface);
  TimeContext context;
  context.path = path_context(outlines, surface, settings.ball_diameter_m, settings.flash_times_s);
  context.px_per_m = context.path.diameter_px / settings.ball_diameter_m;
  context.gravity_mps2 = flight::gravity_mps2(radians(frame.surface_angle_deg));
  context.leftwards = settings.leftwards;
  context.bounce = settings.bounce;
  context.flash_times_s = settings.flash_times_s;
  Path path = find_path(points, context.path);
  if (!path.outliers.empty()) assign_outliers(path, points, context.path);
  TimeOrder order = order_in_time(points, path, context);
  assert(order.sequence.size() == outlines.size());
  frame.images = permuted(frame.images, order.sequence);
  outlines = permuted(outlines, order.sequence);
  set_legs_and_times(order, settings, frame);
  remarks.insert(remarks.end(), order.remarks.begin(), order.remarks.end());
}

}  // namespace strobe::digitize
