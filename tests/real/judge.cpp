#include "tests/real/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace strobe::real {

namespace {

double distance(const Circle& one, const Circle& other) {
  return std::hypot(one.x - other.x, one.y - other.y);
}

double distance(const Circle& circle, Point from, Point to) {
  const double dx = to.x - from.x, dy = to.y - from.y;
  const double along = ((circle.x - from.x) * dx + (circle.y - from.y) * dy) / (dx * dx + dy * dy);
  const double u = std::clamp(along, 0.0, 1.0);
  return std::hypot(circle.x - from.x - u * dx, circle.y - from.y - u * dy);
}

bool lies_on(const Circle& circle, const std::vector<Point>& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (distance(circle, path[i - 1], path[i]) <= kReach * circle.d) return true;
  return false;
}

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Of an image of none. Nothing where it is all that was found of a ball that counts neither way.
const char* what_is(const Circle& image, const Photograph& photograph,
                    const std::vector<const Found*>& image_of) {
  bool is_optional = false, is_ghost = false;
  for (std::size_t i = 0; i < photograph.balls.size(); ++i) {
    const Ball& ball = photograph.balls[i];
    if (distance(ball, image) > kInside * ball.d) continue;
    const bool counts = ball.kind != Kind::optional || image_of[i] != nullptr;
    if (ball.kind != Kind::ghost && counts) return "double";
    (ball.kind == Kind::ghost ? is_ghost : is_optional) = true;
  }
  if (is_optional) return nullptr;
  return is_ghost || lies_on(image, photograph.ghost_path) ? "ghost" : "invented";
}

void add_stray(Score& score, const Circle& image, const std::string_view what) {
  ++(what == "double" ? score.doubles : what == "ghost" ? score.ghosts : score.invented);
  score.strays.push_back({image, what.data()});
}

}  // namespace

Score& Score::operator+=(const Score& other) {
  pictures += other.pictures;
  balls += other.balls;
  found += other.found;
  invented += other.invented;
  ghosts += other.ghosts;
  doubles += other.doubles;
  append(centre_px, other.centre_px);
  append(diameter_px, other.diameter_px);
  append(place, other.place);
  append(size, other.size);
  append(missed, other.missed);
  append(strays, other.strays);
  names.insert(other.names.begin(), other.names.end());
  asked_names.insert(other.asked_names.begin(), other.asked_names.end());
  return *this;
}

std::vector<std::pair<std::size_t, std::size_t>> matched(const std::vector<Ball>& ones,
                                                         const std::vector<Circle>& others) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> near;
  for (std::size_t i = 0; i < ones.size(); ++i)
    for (std::size_t j = 0; j < others.size(); ++j)
      if (const double off = distance(ones[i], others[j]) / ones[i].d; off <= kReach)
        near.emplace_back(off, i, j);
  std::sort(near.begin(), near.end());
  std::vector<bool> is_taken(ones.size()), is_given(others.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [off, i, j] : near) {
    if (is_taken[i] || is_given[j]) continue;
    is_taken[i] = is_given[j] = true;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

Score judged(const Photograph& photograph, const std::vector<Found>& found, double told, double tolerance,
             double per_px) {
  Score score;
  score.pictures = 1;
  const auto& balls = photograph.balls;
  std::vector<const Found*> image_of(balls.size());
  std::vector<bool> is_matched(found.size());
  for (const auto& [i, j] : matched(balls, {found.begin(), found.end()})) {
    image_of[i] = &found[j];
    is_matched[j] = true;
    if (balls[i].kind == Kind::ghost) add_stray(score, found[j], "ghost");
  }
  const double told_px = told * photograph.px_per_m * photograph.ball_diameter_m;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (balls[i].kind != Kind::ball || std::abs(balls[i].d / told_px - 1.0) > tolerance) continue;
    const std::string name = fmt::format("{} {}", photograph.path.string(), i);
    ++score.balls;
    score.asked_names.insert(name);
    if (!image_of[i]) {
      score.missed.push_back(balls[i]);
      continue;
    }
    ++score.found;
    score.names.insert(name);
    score.centre_px.push_back(distance(balls[i], *image_of[i]) / per_px);
    score.diameter_px.push_back((image_of[i]->d - balls[i].d) / per_px);
    if (!image_of[i]->sds) continue;
    const auto& sds = *image_of[i]->sds;
    score.place.push_back({(image_of[i]->x - balls[i].x) / per_px, sds.x / per_px});
    score.place.push_back({(image_of[i]->y - balls[i].y) / per_px, sds.y / per_px});
    score.size.push_back({score.diameter_px.back(), sds.d / per_px});
  }
  for (std::size_t j = 0; j < found.size(); ++j)
    if (const char* what = is_matched[j] ? nullptr : what_is(found[j], photograph, image_of))
      add_stray(score, found[j], what);
  return score;
}

std::size_t changed(const Score& one, const Score& other) {
  return static_cast<std::size_t>(
      std::count_if(one.asked_names.begin(), one.asked_names.end(), [&](const std::string& name) {
        return other.asked_names.contains(name) && one.names.contains(name) != other.names.contains(name);
      }));
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return values.empty() ? std::nan("") : std::sqrt(sum / static_cast<double>(values.size()));
}

Beyond beyond_3_sd(const Score& score, const Agreement& annotators) {
  Beyond beyond;
  const auto count = [&](const std::vector<Deviation>& deviations, double annotation_sd) {
    for (const auto& [error, sd] : deviations)
      beyond.count += std::abs(error) > 3.0 * std::hypot(sd, annotation_sd);
    beyond.of += static_cast<int>(deviations.size());
  };
  // Two annotations' distance has the variance of four coordinates, their diameters' difference that of two.
  count(score.place, 0.5 * annotators.centre_rms_px());
  count(score.size, std::sqrt(0.5) * annotators.diameter_rms_px());
  return beyond;
}

Agreement agreement(const std::vector<Photograph>& photographs) {
  Agreement all;
  for (const Photograph& photograph : photographs) {
    if (!photograph.second) continue;
    const auto &first = photograph.balls, &second = *photograph.second;
    const auto pairs = matched(first, {second.begin(), second.end()});
    std::vector<bool> has_pair(first.size()), is_paired(second.size());
    for (const auto& [i, j] : pairs) {
      has_pair[i] = is_paired[j] = true;
      if (first[i].kind != Kind::ball && second[j].kind != Kind::ball) continue;
      all.centre_px.push_back(distance(first[i], second[j]));
      all.diameter_px.push_back(second[j].d - first[i].d);
    }
    for (std::size_t i = 0; i < first.size(); ++i)
      all.only_one += first[i].kind == Kind::ball && !has_pair[i];
    for (std::size_t j = 0; j < second.size(); ++j)
      all.only_one += second[j].kind == Kind::ball && !is_paired[j];
  }
  return all;
}

}  // namespace strobe::real
