#include "host/commission/balls/balls_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/geometry/line.hpp"
#include "host/assembly/assemble.hpp"
#include "host/commission/camera/light_step.hpp"
#include "host/commission/camera/picture_quality.hpp"

namespace strobe::commission {
namespace {

using reduction::Frame;

/// A camera that delivers nothing is not waited for ball after ball.
constexpr int kMaxWithoutPhotograph = 2;

ShotPlan thrown(const host::RigFile& rig) {
  ShotPlan plan = rig.plan.shot();
  plan.dry = false;
  return plan;
}

double in_photograph_width_m(const host::RigFile& rig, const Frame& frame, double width_px) {
  const double px_per_m = rig.camera.px_per_m.value_or(frame.px_per_m.value_or(0.0));
  return px_per_m > 0.0 ? width_px / px_per_m : 0.6;
}

/// Two coordinates of each centre, but four of each leg.
int freedom_of(const Frame& frame) {
  const auto centres = std::ranges::count_if(frame.images, [](const reduction::BallImage& image) {
    return image.leg == Leg::incoming || image.leg == Leg::rebound;
  });
  return std::max(0, 2 * static_cast<int>(centres) - 8);
}

struct Touchdown {
  double time_s = 0.0;  ///< of the frame
  double spot_m = 0.0;
};

/// Where the line through the last two images before the plate comes down to a radius above it.
std::optional<Touchdown> touchdown_of(const Frame& frame, double px_per_m) {
  std::vector<const reduction::BallImage*> incoming;
  for (const auto& image : frame.images)
    if (image.leg == Leg::incoming) incoming.push_back(&image);
  std::vector<Eigen::Vector2d> points;
  for (const auto& p : frame.surface_px) points.emplace_back(p.x, p.y);
  const auto line = geometry::fit_line(points);
  if (incoming.size() < 2 || !line || px_per_m <= 0.0) return std::nullopt;
  const auto seen = [&](const reduction::BallImage& image) {
    return line->coordinates(Eigen::Vector2d(image.centre_px.x, image.centre_px.y));
  };
  const reduction::BallImage &before = *incoming[incoming.size() - 2], &last = *incoming.back();
  const Eigen::Vector2d a = seen(before), b = seen(last);
  if (a.y() <= b.y()) return std::nullopt;
  const double further = (b.y() - 0.5 * last.diameter_px) / (a.y() - b.y());
  return Touchdown{last.time_s + further * (last.time_s - before.time_s),
                   (b.x() + further * (b.x() - a.x()) + line->origin().x()) / px_per_m};
}

/// The instant of the first image, after the machine's trigger.
std::optional<double> first_image_s(const FiredShot& shot) {
  const auto& imaged = shot.result.readout.flashes;
  const MonoTime trigger = from_ns(shot.shot.trigger_ns);
  if (!imaged || !known(trigger)) return std::nullopt;
  for (const strobe_msgs::flash_t& flash : shot.shot.flashes)
    if (flash.flash_index == imaged->first && known(from_ns(flash.issue_end_ns)))
      return to_seconds(from_ns(flash.issue_end_ns) - trigger);
  return std::nullopt;
}

}  // namespace

const std::vector<StepInfo>& BallsStep::infos() const {
  static const std::vector<StepInfo> infos{
      {"throws", "each throw is one ball", {"machine", "lines"}},
      {"focus", "sharp edges of balls", {"camera"}},
      {"exposure", "neither white nor dark", {"camera", "lamps"}},
      {"transfer", "numbers proportional to light", {"camera"}},
      {"flashes", "flashes against the photograph", {"lamps", "sensors", "plan", "camera"}},
      {"scale", "scale by the balls' size", {"ball", "camera"}},
      {"square", "camera square to the balls' plane", {"camera"}},
      {"noise", "noise against what is stated", {"camera", "ball", "analysis"}},
      {"repeatability", "lag, spot and speed from ball to ball", {"machine"}},
  };
  return infos;
}

std::string BallsStep::briefing(const host::RigFile& rig) const {
  return fmt::format(
      "{} BALLS ARE THROWN, with lamps and shutter. Slowest speed; feed the machine, clear the lane, nobody "
      "in front "
      "of it; key on, e-stop released.",
      rig.commission.balls);
}

void BallsStep::begin(const Situation& situation) {
  rig_ = &situation.rig;
  Fire fire;
  fire.plan = thrown(situation.rig);
  fire.words = "a ball is thrown";
  fire.photograph = true;
  shots_ = ShotCollector(std::vector<Fire>(static_cast<std::size_t>(situation.rig.commission.balls), fire));
  pictures_ = {};
  pictured_.clear();
  gate_edges_.clear();
  edges_ = without_photograph_ = 0;
}

void BallsStep::on_event(const strobe_msgs::event_t& event, HostTime) {
  if (event.kind == strobe_msgs::event_t::SHOT_STARTED) edges_ = 0;
  if (event.kind == strobe_msgs::event_t::GATE) ++edges_;
}

void BallsStep::on_shot(FiredShot shot) {
  if (why_unsound(shot).empty()) {
    gate_edges_.push_back(edges_);
    if (!shot.photograph) ++without_photograph_;
    if (shot.photograph && rig_ != nullptr) {
      pictured_.push_back(shots_.shots().size());
      pictures_.add(*shot.photograph, *rig_, host::flash_times_s(shot.shot));
    }
  }
  edges_ = 0;
  shots_.add(std::move(shot));
}

std::vector<StepResult> BallsStep::all_skipped(StepResult first) const {
  std::vector<StepResult> results{std::move(first)};
  for (std::size_t i = 1; i < infos().size(); ++i)
    results.push_back(skipped(infos()[i].id, "no balls were measured", "let step throws pass first"));
  return results;
}

Request BallsStep::step(const Situation& situation) {
  if (without_photograph_ >= kMaxWithoutPhotograph)
    return Done{all_skipped(no_photograph("throws", situation.rig))};
  if (const Fire* const wanted = shots_.next()) return *wanted;
  if (!shots_.problem().empty())
    return Done{all_skipped(
        failed("throws", "no_shot", shots_.problem(), "mend what it names, and run the step again"))};
  if (!pictures_.ready()) return Wait{"the photographs are measured", Act::none};
  return Done{judge(situation)};
}

std::vector<StepResult> BallsStep::judge(const Situation& situation) {
  const host::RigFile& rig = situation.rig;
  std::vector<BallShot> shots(shots_.shots().size());
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const FiredShot& fired = shots_.shots()[i];
    shots[i].rejected = fired.result.rejected;
    shots[i].readout = fired.result.readout;
    shots[i].gate_edges = gate_edges_[i];
  }
  std::vector<PictureQuality> qualities;
  std::vector<Frame> frames;
  double width_px = 1.0, height_px = 1.0, px_per_m = rig.camera.px_per_m.value_or(0.0);
  auto pictures = pictures_.take();
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    if (!pictures[k].measured) continue;
    const host::MeasuredPhotograph& m = *pictures[k].measured;
    const Frame& frame = m.found.frame;
    if (px_per_m <= 0.0 && m.settings.px_per_m) px_per_m = *m.settings.px_per_m;
    width_px = m.photograph.width(), height_px = m.photograph.height();
    BallShot& shot = shots[pictured_[k]];
    shot.images = static_cast<int>(frame.images.size());
    shot.centres = freedom_of(frame);
    const auto touchdown = touchdown_of(frame, px_per_m);
    const auto first = first_image_s(shots_.shots()[pictured_[k]]);
    if (touchdown) shot.spot_m = touchdown->spot_m;
    if (touchdown && first && !shot.rejected)
      shot.lag_s = *first + touchdown->time_s - frame.images.front().time_s;
    qualities.push_back(picture_quality(m.photograph, m.settings.map, m.found));
    frames.push_back(frame);
  }
  std::vector<StepResult> results{judge_throws("throws", shots, rig.limits.gate_fitted),
                                  judge_focus("focus", qualities), judge_exposure("exposure", qualities),
                                  judge_transfer("transfer", qualities), judge_flashes("flashes", shots)};
  if (px_per_m <= 0.0) {
    for (const char* id : {"scale", "square"})
      results.push_back(
          failed(id, "no_scale", "the rig file has no scale", "calibrate the camera with a printed board"));
  } else if (const auto check = check_scale(frames, px_per_m, rig.ball.diameter_m, width_px, height_px)) {
    results.push_back(judge_scale("scale", *check, rig.ball.diameter_sd_m / rig.ball.diameter_m,
                                  rig.camera.px_per_m_sd.value_or(0.0) / px_per_m));
    results.push_back(judge_squareness("square", *check));
  } else {
    for (const char* id : {"scale", "square"})
      results.push_back(
          failed(id, "no_images", check.error().message, "let step focus and exposure pass first"));
  }
  results.push_back(judge_noise("noise", shots));
  const double view_m = frames.empty() ? 0.6 : in_photograph_width_m(rig, frames.front(), width_px);
  results.push_back(judge_repeatability("repeatability", shots, rig.machine_lag_s, view_m));
  return results;
}

}  // namespace strobe::commission
