#include "host/digitize/refit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {
namespace {

// With fewer outlines their common size is too uncertain to reject one by it.
constexpr std::size_t kMinForRefit = 4;

Candidate candidate_at(const PlaneMap& map, cv::Point2d at, double diameter) {
  const cv::Point2d centre = map.to_image(at);
  const cv::Point2d side = map.to_image(at + cv::Point2d(0.5 * diameter, 0.0));
  return {.centre_image = centre, .radius_image_px = cv::norm(side - centre)};
}

bool is_known(std::span<const Outline> outlines, cv::Point2d place) {
  return std::ranges::any_of(outlines, [&](const Outline& o) {
    return cv::norm(o.centre - place) < kSameThingOfDiameter * o.diameter;
  });
}

/// What was left out for its size, or for want of precision, which the others' size may help.
std::vector<std::size_t> left_out_by_size(std::span<const Unmeasured> unmeasured,
                                          std::span<const Outline> outlines) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < unmeasured.size(); ++i) {
    const Unmeasured& one = unmeasured[i];
    const bool by_size = one.why.reason == Reason::imprecise || one.why.reason == Reason::wrong_size;
    if (by_size && !is_known(outlines, one.centre)) places.push_back(i);
  }
  return places;
}

bool is_inconsistent(const Outline& o, const SizeModel& size) {
  const double sd = std::hypot(o.diameter_sd(), size.sd, size.spread);
  return std::abs(o.diameter - size.at(o.centre.x)) > kFarthest_sd * sd;
}

}  // namespace

void refit_by_size(const Photograph& photograph, const PlaneMap& map, OutlineSettings settings,
                   const SizeModel& size, std::vector<Outline>& outlines,
                   std::vector<Unmeasured>& unmeasured) {
  if (outlines.size() < kMinForRefit) return;
  const std::vector<std::size_t> left_out = left_out_by_size(unmeasured, outlines);
  std::vector<Candidate> candidates;
  for (const std::size_t i : left_out)
    candidates.push_back(candidate_at(map, unmeasured[i].centre, size.at(unmeasured[i].centre.x)));
  std::vector<std::size_t> again;
  std::vector<Outline> others;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const Outline& o = outlines[i];
    if (!is_inconsistent(o, size)) {
      others.push_back(o);
      continue;
    }
    again.push_back(i);
    candidates.push_back(candidate_at(map, o.centre, o.diameter));
  }
  settings.diameter_px = size.diameter;
  settings.diameter_slope = size.slope;
  const cv::Point2d middle = map.to_plane({0.5 * photograph.width(), 0.5 * photograph.height()});
  settings.diameter_sd_px = std::max(std::hypot(size.sd, size.spread), kSdOfDiameter * size.at(middle.x));
  settings.neighbours = others;
  const auto fitted = fit_outlines(photograph, map, candidates, settings).outlines;
  for (std::size_t k = 0; k < again.size(); ++k) {
    const auto& one = fitted[left_out.size() + k];
    Outline& before = outlines[again[k]];
    if (one && one->centre_sd() <= before.centre_sd()) before = *one;
  }
  // The best supported first, as candidates come.
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < left_out.size(); ++k) {
    if (!fitted[k] || is_known(outlines, fitted[k]->centre)) continue;
    outlines.push_back(*fitted[k]);
    found.push_back(left_out[k]);
  }
  for (auto i = found.rbegin(); i != found.rend(); ++i)
    unmeasured.erase(unmeasured.begin() + static_cast<std::ptrdiff_t>(*i));
}

}  // namespace strobe::digitize
