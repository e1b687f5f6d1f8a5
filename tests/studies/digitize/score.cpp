#include "tests/studies/digitize/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/units/angles.hpp"

namespace strobe::studies::digitize {

namespace {

using reduction::BallImage;
using reduction::Leg;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Said of this image, and not of the next one.
bool is_reported(const TrueImage& image, const std::string& what,
                 const std::vector<ReportedPlace>& reported) {
  return std::ranges::any_of(reported, [&](const ReportedPlace& place) {
    return place.what == what && std::hypot(place.at_px.x - image.centre_px.x,
                                            place.at_px.y - image.centre_px.y) <= 0.25 * image.diameter_px;
  });
}

void measure_centre(const TrueImage& truth, const BallImage& image, Score& score) {
  const double dx = image.centre_px.x - truth.centre_px.x;
  const double dy = image.centre_px.y - truth.centre_px.y;
  const auto& c = image.centre_cov_px2;
  score.x_px.add(dx, c ? std::optional(std::sqrt((*c)[0])) : std::nullopt);
  score.y_px.add(dy, c ? std::optional(std::sqrt((*c)[3])) : std::nullopt);
  if (!c) return;
  const double det = (*c)[0] * (*c)[3] - (*c)[1] * (*c)[2];
  const double squared = ((*c)[3] * dx * dx - ((*c)[1] + (*c)[2]) * dx * dy + (*c)[0] * dy * dy) / det;
  score.mahalanobis.add(std::sqrt(0.5 * squared), 1.0);
}

void measure_airborne(const TrueImage& truth, const BallImage& image, Score& score) {
  ++score.found;
  measure_centre(truth, image, score);
  score.diameter_px.add(image.diameter_px - truth.diameter_px, image.diameter_sd_px);
  if (!truth.equator_rad) {
    score.lines_invented += image.equator_rad ? 1 : 0;
    return;
  }
  ++score.lines;
  if (!image.equator_rad) return;
  ++score.lines_found;
  score.equator_rad.add(wrap_half_turn(*image.equator_rad - *truth.equator_rad), image.equator_sd_rad);
  if (!truth.equator_tilt_rad || !image.equator_tilt_rad) return;
  const bool reversed = std::cos(*image.equator_rad - *truth.equator_rad) < 0.0;
  const double error_rad = *image.equator_tilt_rad * (reversed ? -1.0 : 1.0) - *truth.equator_tilt_rad;
  score.tilt_rad.add(std::copysign(1.0, *truth.equator_tilt_rad) * error_rad, image.equator_tilt_sd_rad);
}

void measure_contact(const TrueImage& truth, const BallImage& image, Score& score) {
  ++score.contact_found;
  if (truth.top_px && image.top_px) score.top_px.add(image.top_px->y - truth.top_px->y, std::nullopt);
  if (truth.contact_width_px && image.contact_width_px)
    score.contact_width_px.add(*image.contact_width_px - *truth.contact_width_px, std::nullopt);
}

}  // namespace

std::vector<Pair> pairs_of(const std::vector<TrueImage>& truth, const std::vector<BallImage>& images) {
  std::vector<Pair> near;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    const double reach_px =
        (truth[t].leg == Leg::contact || !truth[t].whole ? 0.25 : 0.1) * truth[t].diameter_px;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const double distance_px = std::hypot(images[i].centre_px.x - truth[t].centre_px.x,
                                            images[i].centre_px.y - truth[t].centre_px.y);
      if (distance_px <= reach_px) near.push_back({t, i, distance_px});
    }
  }
  std::ranges::stable_sort(near, {}, &Pair::distance_px);
  std::vector<char> truth_taken(truth.size()), image_taken(images.size());
  std::vector<Pair> pairs;
  for (const Pair& pair : near) {
    if (truth_taken[pair.truth] != 0 || image_taken[pair.image] != 0) continue;
    truth_taken[pair.truth] = image_taken[pair.image] = 1;
    pairs.push_back(pair);
  }
  return pairs;
}

void ErrorTally::add(double error, std::optional<double> sd) {
  ++count;
  squares += error * error;
  sum += error;
  largest = std::max(largest, std::abs(error));
  if (!sd) return;
  ++stated;
  normalized_squares += (error / *sd) * (error / *sd);
  if (std::abs(error) > kWild_sd * *sd) ++wild;
}

void ErrorTally::add(const ErrorTally& other) {
  count += other.count;
  squares += other.squares;
  sum += other.sum;
  largest = std::max(largest, other.largest);
  stated += other.stated;
  normalized_squares += other.normalized_squares;
  wild += other.wild;
}

double ErrorTally::rms() const { return count > 0 ? std::sqrt(squares / count) : kUnknown; }
double ErrorTally::bias() const { return count > 0 ? sum / count : kUnknown; }
double ErrorTally::normalized() const {
  return stated > 0 ? std::sqrt(normalized_squares / stated) : kUnknown;
}

void Score::add(const Score& other) {
  airborne += other.airborne;
  found += other.found;
  reported += other.reported;
  contact += other.contact;
  contact_found += other.contact_found;
  cut += other.cut;
  invented += other.invented;
  lines += other.lines;
  lines_found += other.lines_found;
  lines_reported += other.lines_reported;
  lines_invented += other.lines_invented;
  for (const auto member :
       {&Score::x_px, &Score::y_px, &Score::mahalanobis, &Score::diameter_px, &Score::equator_rad,
        &Score::tilt_rad, &Score::top_px, &Score::contact_width_px, &Score::surface_px})
    (this->*member).add(other.*member);
}

Score score(const std::vector<TrueImage>& truth, const reduction::Frame& frame,
            const std::vector<ReportedPlace>& reported) {
  Score result;
  for (const TrueImage& image : truth)
    if (!image.whole)
      ++result.cut;
    else
      ++(image.leg == Leg::contact ? result.contact : result.airborne);
  const auto pairs = pairs_of(truth, frame.images);
  result.invented = static_cast<int>(frame.images.size() - pairs.size());
  std::vector<char> found(truth.size());
  for (const Pair& pair : pairs) {
    const TrueImage& image = truth[pair.truth];
    found[pair.truth] = 1;
    if (!image.whole) continue;
    const auto measure = image.leg == Leg::contact ? measure_contact : measure_airborne;
    const int lines_missed = result.lines - result.lines_found;
    measure(image, frame.images[pair.image], result);
    if (result.lines - result.lines_found > lines_missed && is_reported(image, "equator", reported))
      ++result.lines_reported;
  }
  for (std::size_t t = 0; t < truth.size(); ++t) {
    const bool missed = truth[t].whole && truth[t].leg != Leg::contact && found[t] == 0;
    if (missed && is_reported(truth[t], "image", reported)) ++result.reported;
  }
  return result;
}

void score_surface(const std::vector<reduction::PointPx>& line, const reduction::Frame& frame, Score& score) {
  if (line.size() < 2 || frame.surface_px.empty()) return;
  const double slope = (line[1].y - line[0].y) / (line[1].x - line[0].x);
  double sum_px = 0.0;
  for (const reduction::PointPx& p : frame.surface_px) sum_px += p.y - line[0].y - slope * (p.x - line[0].x);
  const auto count = static_cast<double>(frame.surface_px.size());
  const double lowest_px = score.found > 0 ? score.y_px.bias() - 0.5 * score.diameter_px.bias() : 0.0;
  score.surface_px.add(sum_px / count - lowest_px, frame.surface_sd_px
                                           ? std::optional(*frame.surface_sd_px / std::sqrt(count))
                                           : std::nullopt);
}

void TimeCount::add(const TimeCount& other) {
  measured += other.measured;
  wrong += other.wrong;
}

TimeCount count_times(const std::vector<TrueImage>& truth, const std::vector<double>& times_s,
                      const reduction::Frame& frame) {
  std::vector<double> late_s;
  for (const Pair& pair : pairs_of(truth, frame.images)) {
    const BallImage& image = frame.images[pair.image];
    if (std::isfinite(image.time_s)) late_s.push_back(image.time_s - times_s[pair.truth]);
  }
  if (late_s.empty()) return {};
  std::ranges::sort(late_s);
  const double common_s = late_s[late_s.size() / 2];
  const auto wrong =
      std::ranges::count_if(late_s, [&](double late) { return std::abs(late - common_s) > 1e-3; });
  return {static_cast<int>(late_s.size()), static_cast<int>(wrong)};
}

}  // namespace strobe::studies::digitize
