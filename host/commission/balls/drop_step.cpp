#include "host/commission/balls/drop_step.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/ball/ball.hpp"
#include "host/commission/balls/ball_judgement.hpp"
#include "host/commission/camera/light_step.hpp"

namespace strobe::commission {
namespace {

/// Of a ball that falls with 3 to 4 m/s: images 30 to 50 mm apart, half overlapping.
constexpr Duration kPeriod = std::chrono::milliseconds{12};
/// From the first flash: a person lets go as the flashes begin, the ball falls for half a second and leaves the view again.
constexpr Duration kExposure = std::chrono::milliseconds{1300};
constexpr int kDrops = 5;

ShotPlan slow_train(const host::RigFile& rig) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(kPeriod, rig.limits.lamp_period);
  plan.exposure = std::min(kExposure, rig.limits.longest_exposure);
  plan.impact_at = plan.exposure / 2;
  return plan;
}

std::vector<StepResult> both(StepResult gravity, const std::string& why) {
  return {std::move(gravity), skipped("inclination", why)};
}

}  // namespace

const std::vector<StepInfo>& DropStep::infos() const {
  static const std::vector<StepInfo> infos{
      {"gravity", "gravity by dropped balls: scale and clock", {"camera", "ball", "analysis", "commission"}},
      {"inclination", "the plate's inclination by dropped balls", {"camera", "analysis"}}};
  return infos;
}

std::string DropStep::briefing(const host::RigFile&) const {
  return fmt::format(
      "FLASHES for {:.1f} s, {} times, slowly; the machine's trigger stays still. Hold a ball a metre over "
      "the plate, above "
      "the middle of the view and in the plane where balls fly; let it go, without spin, as the flashes "
      "begin.",
      to_seconds(kExposure), kDrops);
}

void DropStep::begin(const Situation& situation) {
  rig_ = &situation.rig;
  Fire fire;
  fire.plan = slow_train(situation.rig);
  fire.words = "let a ball go as the flashes begin";
  fire.photograph = true;
  shots_ = ShotCollector(std::vector<Fire>(kDrops, fire));
  pictures_ = {};
  photograph_missing_ = false;
}

void DropStep::on_shot(FiredShot shot) {
  if (why_unsound(shot).empty()) {
    if (!shot.photograph) photograph_missing_ = true;
    if (shot.photograph && rig_ != nullptr)
      pictures_.add(*shot.photograph, *rig_, host::flash_times_s(shot.shot));
  }
  shots_.add(std::move(shot));
}

Request DropStep::step(const Situation& situation) {
  if (photograph_missing_)
    return Done{both(no_photograph("gravity", situation.rig), "there is no photograph")};
  if (const Fire* const wanted = shots_.next()) return *wanted;
  if (!shots_.problem().empty())
    return Done{
        both(failed("gravity", "no_shot", shots_.problem(), "mend what it names, and run the step again"),
             "the shots were not fired")};
  if (!pictures_.ready()) return Wait{"the photographs are measured", Act::none};
  return Done{judge(situation)};
}

std::vector<StepResult> DropStep::judge(const Situation& situation) {
  const host::RigFile& rig = situation.rig;
  std::vector<reduction::Frame> frames;
  for (auto& picture : pictures_.take())
    if (picture.measured) frames.push_back(std::move(picture.measured->found.frame));
  if (!rig.camera.px_per_m)
    return both(failed("gravity", "no_scale", "the rig file has no scale",
                       "calibrate the camera with a printed board"),
                "the rig file has no scale");
  const double temperature =
      std::atof(rig.record.contains("temperature_c") ? rig.record.at("temperature_c").c_str() : "20");
  for (reduction::Frame& frame : frames) frame.temperature_c = temperature;
  ball::Ball ball;
  ball.diameter_m = rig.ball.diameter_m;
  ball.mass_kg = rig.ball.mass_kg.value_or(ball.mass_kg);
  const auto fall = measure_free_fall(frames, ball, *rig.camera.px_per_m);
  if (!fall)
    return both(failed("gravity", "no_drop", "no dropped ball is seen: " + fall.error().message,
                       "let the ball go as the flashes begin, above the middle of the view"),
                "no dropped ball is seen");
  return {judge_gravity("gravity", *fall, rig.commission.gravity_mps2,
                        rig.camera.px_per_m_sd.value_or(0.0) / *rig.camera.px_per_m),
          judge_inclination("inclination", *fall, rig.analysis.surface_angle_deg.value_or(0.0))};
}

}  // namespace strobe::commission
