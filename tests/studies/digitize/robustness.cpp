#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>

#include "common/units/angles.hpp"
#include "tests/studies/digitize/crowded.hpp"
#include "tests/studies/digitize/in_order.hpp"
#include "tests/studies/digitize/photographs.hpp"
#include "tests/studies/digitize/reliability.hpp"
#include "tests/studies/digitize/score.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/studies/digitize/tables.hpp"

namespace strobe::studies::digitize {

namespace {

using sim::Scene;

/// What else was told of a photograph, and how long it took.
struct Crowd {
  int doubles = 0;  ///< of those invented, at an image that was found
  int others = 0;   ///< of those invented, images of a second ball
  int others_there = 0;
  int remarks = 0;  ///< photographs with any
  std::vector<double> ms{};  ///< of the processor, a photograph each

  void add(const Crowd& other) {
    doubles += other.doubles;
    others += other.others;
    others_there += other.others_there;
    remarks += other.remarks;
    ms.insert(ms.end(), other.ms.begin(), other.ms.end());
  }
};

/// One condition of an axis and what was measured under it.
struct RobustnessPoint {
  std::string axis;
  std::string label;
  Score score;
  TimeCount times;
  Crowd crowd;
};

struct Condition {
  std::string axis;
  std::string label;
  std::function<void(Take&)> apply;
};

using Setter = std::function<void(Take&, double)>;

void add(std::vector<Condition>& all, const std::string& axis, const std::vector<double>& values,
         const Setter& set) {
  for (const double value : values)
    all.push_back({axis, fmt::format("{:g}", value), [=](Take& take) { set(take, value); }});
}

void lose_flash(Take& take, double from_impact) {
  if (from_impact == 0.0) return;
  sim::Fault fault;
  fault.kind = sim::FaultKind::flash_missing;
  fault.flash_from_impact = static_cast<int>(from_impact);
  take.scene.faults.push_back(fault);
}

/// Of either renderer's sensor, over the usual.
void set_noise(Take& take, double factor) {
  take.look.noise = factor;
  take.scene.photograph.full_well_e /= factor * factor;
  take.scene.photograph.read_noise_e /= factor;  // in electrons of fewer
}

/// The spin's axis turned off the camera's, about the vertical.
void turn_spin(Take& take, double by_deg) {
  auto& machine = take.scene.machine;
  machine.sidespin_radps = machine.spin_radps * std::sin(radians(by_deg));
  machine.spin_radps *= std::cos(radians(by_deg));
}

/// Of everything something: 1 as in a tidy lab, 4 as nobody would take photographs.
void set_distractors(Take& take, double much) {
  take.distractors = {
      .round_things = static_cast<int>(4.0 * much), .texture = 0.03 * much, .trail = 0.07 * much};
  take.scene.photograph.blur_px = 0.7 * much;
  take.scene.photograph.exposure /= much;
  set_noise(take, much);
}

std::vector<Condition> conditions() {
  std::vector<Condition> all;
  add(all, "exposure", {0.0625, 0.125, 0.25, 0.5, 1, 2, 4, 8},
      [](Take& t, double v) { t.scene.photograph.exposure = v; });
  add(all, "line_contrast", {0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1},
      [](Take& t, double v) { t.scene.ball_appearance.line_contrast = v; });
  add(all, "line_tilt", {0, 1, 2, 3, 4, 5, 6, 8, 15, 30, 45, 60},
      [](Take& t, double v) { t.scene.ball_appearance.line_tilt_rad = radians(v); });
  add(all, "line_offset", {0, 0.01, 0.02, 0.03},
      [](Take& t, double v) { t.scene.ball_appearance.line_offset = v; });
  add(all, "spin_axis", {0, 5, 15, 30, 45, 60}, turn_spin);
  add(all, "blur", {0, 0.5, 1, 2, 3, 4, 5}, [](Take& t, double v) { t.scene.photograph.blur_px = v; });
  add(all, "blobs", {0, 1, 2, 3, 4},
      [](Take& t, double v) { t.scene.background.blobs = static_cast<int>(v); });
  add(all, "lamp_a", {1, 0.5, 0.2, 0.1, 0}, [](Take& t, double v) { t.scene.photograph.lamp_a_power = v; });
  add(all, "lamp_b", {1, 0.5, 0.2, 0.1, 0}, [](Take& t, double v) { t.scene.photograph.lamp_b_power = v; });
  add(all, "flash_lost", {-3, -2, -1, 0, 1, 2, 3}, lose_flash);
  add(all, "second_flash", {0, 0.02, 0.05, 0.1, 0.2, 0.4},
      [](Take& t, double v) { t.scene.photograph.second_flash = v; });
  add(all, "noise", {0.5, 1, 2, 4, 8}, set_noise);
  add(all, "gamma", {1, 0.9, 0.8, 0.6, 0.45}, [](Take& t, double v) { t.scene.photograph.gamma = v; });
  add(all, "jpeg", {0, 95, 90, 85, 70, 50}, [](Take& t, double v) { t.jpeg_quality = static_cast<int>(v); });
  add(all, "size", {12, 16, 24, 40, 80, 160, 300, 500}, set_size);
  add(all, "images", {3, 5, 10, 20, 40, 60}, set_images);
  add(all, "overlap", {1.2, 0.8, 0.5, 0.4, 0.33}, set_overlap);
  add(all, "rolling", {0.5, 0.2, 0.05}, set_rolling);
  add(all, "skimming", {20, 5, 1}, set_skimming);
  add(all, "bounces", {2, 3, 4}, set_bounces);
  add(all, "second_ball_ms", {0, 4.5, 10, 22}, set_second_ball);
  add(all, "round_things", {3, 10, 30},
      [](Take& t, double v) { t.distractors.round_things = static_cast<int>(v); });
  add(all, "texture", {0.03, 0.1, 0.2}, [](Take& t, double v) { t.distractors.texture = v; });
  add(all, "trail", {0.1, 0.2, 0.3, 0.5}, [](Take& t, double v) { t.distractors.trail = v; });
  add(all, "distractors", {1, 2, 3, 4}, set_distractors);
  add(all, "ball_at_rest", {-4, -2, 2, 4}, set_ball_at_rest);
  return all;
}

/// The figures that are to be reached, of which nothing is to be invented.
bool holds(const Score& s) {
  return s.found == s.airborne && s.invented == 0 && centre_rms_px(s) <= 0.1 && s.diameter_px.rms() <= 0.2 &&
         s.lines_found == s.lines && degrees(s.equator_rad.rms()) <= 0.2;
}

std::string missed_words(const Score& s) {
  std::vector<std::string> words;
  if (s.found < s.airborne)
    words.push_back(fmt::format("{} missed ({} said)", s.airborne - s.found, s.reported));
  if (s.invented > 0) words.push_back(fmt::format("{} invented", s.invented));
  if (!(centre_rms_px(s) <= 0.1)) words.push_back(fmt::format("centre {:.2f} px", centre_rms_px(s)));
  if (!(s.diameter_px.rms() <= 0.2)) words.push_back(fmt::format("diameter {:.2f} px", s.diameter_px.rms()));
  if (s.lines_found < s.lines)
    words.push_back(fmt::format("{} of {} equators not reported ({} said)", s.lines - s.lines_found, s.lines,
                                s.lines_reported));
  if (s.lines_found > 0 && !(degrees(s.equator_rad.rms()) <= 0.2))
    words.push_back(fmt::format("equator {:.2f} deg", degrees(s.equator_rad.rms())));
  return fmt::format("{}", fmt::join(words, ", "));
}

constexpr int kShotNameWidth = 21;

void tell(const std::vector<RobustnessPoint>& points) {
  fmt::print(
      "\nBeyond the figures (all found, none invented, centre .1 px, diameter .2 px, equator .2 deg):\n");
  for (const RobustnessPoint& p : points) {
    const std::string name = fmt::format("{} {}", p.axis, p.label);
    if (!holds(p.score)) fmt::print("  {:<{}} {}\n", name, kShotNameWidth, missed_words(p.score));
    if (p.times.wrong > 0)
      fmt::print("  {:<{}} {} of {} at a wrong interval\n", name, kShotNameWidth, p.times.wrong,
                 p.times.measured);
  }
}

Result<void> write_csv(const std::vector<RobustnessPoint>& points, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file << "axis,value," << score_csv_head() << ",times,wrong_times\n";
  for (const RobustnessPoint& p : points)
    file << fmt::format("{},{},{},{},{}\n", p.axis, p.label, score_csv(p.score), p.times.measured,
                        p.times.wrong);
  file.close();
  if (!file) return fail(path + ": cannot be written");
  return {};
}

struct Measured {
  Score score;
  TimeCount times;
  Crowd crowd;
  Reliability reliability{};
};

void tell_crowds(const std::vector<RobustnessPoint>& points, bool timed) {
  fmt::print("\n{:<{}} {:>8} {:>8} {:>11} {:>8} {}\n", "", kShotNameWidth, "invented", "doubles", "2nd ball's",
             "remarks", timed ? " processor ms: median largest" : "");
  for (const RobustnessPoint& p : points) {
    std::vector<double> ms = p.crowd.ms;
    std::ranges::sort(ms);
    fmt::print("{:<{}} {:>8} {:>8} {:>5}/{:<5} {:>8}", p.axis + " " + p.label, kShotNameWidth, p.score.invented,
               p.crowd.doubles, p.crowd.others, p.crowd.others_there, p.crowd.remarks);
    fmt::print("{}\n", timed ? fmt::format("  {:>20.0f} {:>7.0f}", ms[ms.size() / 2], ms.back()) : "");
  }
}

bool near_any(const reduction::BallImage& image, const std::vector<TrueImage>& of, double share) {
  return std::ranges::any_of(of, [&](const TrueImage& true_image) {
    return std::hypot(image.centre_px.x - true_image.centre_px.x, image.centre_px.y - true_image.centre_px.y) <
           share * true_image.diameter_px;
  });
}

Crowd crowd_of(const KnownPhotograph& known, const strobe::digitize::Digitization& digitization) {
  const auto& images = digitization.frame.images;
  std::vector<char> taken(images.size(), 0);
  for (const Pair& pair : pairs_of(known.truth, images)) taken[pair.image] = 1;
  Crowd crowd;
  crowd.others_there = static_cast<int>(std::ranges::count_if(known.others, &TrueImage::whole));
  crowd.remarks = digitization.remarks.empty() ? 0 : 1;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (taken[i] != 0) continue;
    if (near_any(images[i], known.others, 0.25))
      ++crowd.others;
    else
      crowd.doubles += near_any(images[i], known.truth, 0.25) ? 1 : 0;
  }
  return crowd;
}

/// Of what was stated of each image that the machine found.
Reliability reliability_of(const KnownPhotograph& known, const reduction::Frame& frame) {
  std::vector<char> taken(frame.images.size(), 0);
  for (const Pair& pair : pairs_of(known.truth, frame.images)) taken[pair.image] = 1;
  Reliability reliability;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const auto& image = frame.images[i];
    if (image.probability)
      reliability.add(*image.probability, taken[i] != 0                         ? Reliability::Is::ball
                                          : near_any(image, known.others, 0.25) ? Reliability::Is::other_ball
                                                                                : Reliability::Is::none);
  }
  return reliability;
}

Result<Measured> measure(const Take& take, strobe::digitize::Effort effort) {
  auto known = known_photograph(take);
  if (!known) return tl::unexpected(known.error());
  known->settings.effort = effort;
  // The processor's time, of all threads: the machine may do other things, too.
  const std::clock_t start = std::clock();
  const auto result = strobe::digitize::digitize(known->photograph, known->settings);
  const double took_ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (!result) return tl::unexpected(result.error());
  Measured measured{score(known->truth, result->frame, reported_places(*result)),
                    count_times(known->truth, known->times_s, result->frame), crowd_of(*known, *result)};
  measured.crowd.ms.push_back(took_ms);
  measured.reliability = reliability_of(*known, result->frame);
  score_surface(known->surface_px, result->frame, measured.score);
  return measured;
}

Result<std::vector<Condition>> wanted(const std::vector<std::string>& axes) {
  std::vector<Condition> all = conditions();
  for (const std::string& axis : axes)
    if (std::ranges::none_of(all, [&](const Condition& c) { return c.axis == axis; }))
      return fail("--axis " + axis + ": is none");
  if (!axes.empty())
    std::erase_if(all, [&](const Condition& c) { return std::ranges::find(axes, c.axis) == axes.end(); });
  return all;
}

/// Photographs of one scene and shot look different under each condition.
std::filesystem::path kept_in(const Options& options, const Condition& condition) {
  if (options.keep.empty()) return {};
  return std::filesystem::path(options.keep) / fmt::format("{}_{}", condition.axis, condition.label);
}

}  // namespace

Result<void> study_robustness(const Options& options) {
  const std::vector<std::string> usual{"zero_41", "top_34", "back_59"};
  const auto scenes = scenes_of(options, options.scenes.empty() ? usual : options.scenes);
  if (!scenes) return tl::unexpected(scenes.error());
  const auto all = wanted(options.axes);
  if (!all) return tl::unexpected(all.error());
  const auto shots = static_cast<std::size_t>(options.shots.value_or(2));
  const std::size_t of_point = scenes->size() * shots;
  std::vector<RobustnessPoint> points;
  Reliability reliability;
  print_score_head(kShotNameWidth);
  const auto done = try_in_order(
      all->size() * of_point, options.jobs,
      [&](std::size_t i) {
        Take take{(*scenes)[i % of_point / shots],
                  options.seed,
                  static_cast<int>(i % shots) + 1,
                  kept_in(options, (*all)[i / of_point]),
                  options.independent};
        take.shooting = shooting_of(options, take.scene);
        (*all)[i / of_point].apply(take);
        return measure(take, options.effort);
      },
      [&](std::size_t i, const Measured& measured) {
        const Condition& c = (*all)[i / of_point];
        if (i % of_point == 0) points.push_back({c.axis, c.label, {}, {}, {}});
        points.back().score.add(measured.score);
        points.back().times.add(measured.times);
        points.back().crowd.add(measured.crowd);
        reliability.add(measured.reliability);
        if ((i + 1) % of_point == 0) print_score(c.axis + " " + c.label, kShotNameWidth, points.back().score);
      });
  if (!done) return done;
  tell(points);
  tell_crowds(points, options.jobs == 1);
  reliability.print();
  return options.csv.empty() ? Result<void>{} : write_csv(points, options.csv);
}

}  // namespace strobe::studies::digitize
