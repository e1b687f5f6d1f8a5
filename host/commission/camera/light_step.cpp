#include "host/commission/camera/light_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/commission/camera/light_judgement.hpp"

namespace strobe::commission {
namespace {

constexpr const char* kLight = "light";
constexpr const char* kWindow = "exposure_window";
/// Light of a hundred flashes that vary by 5 % is known to 0.5 %; sixteen at either end of the exposure.
constexpr int kFlashes = 100, kFlashesAtEnds = 16;
/// Of the exposure, left dark at either end: the shutter's lag varies.
constexpr int kMargin = 50;

enum class Where { middle, beginning, end };

/// So many flashes in an exposure as long as the rig's plan has.
ShotPlan train(const host::RigFile& rig, Lamps lamps, int flashes, Where where) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(rig.plan.even.period, rig.limits.lamp_period);
  plan.exposure = std::min(rig.plan.even.exposure, rig.limits.longest_exposure);
  plan.impact_at = plan.exposure / 2;
  const Duration margin = plan.exposure / kMargin;
  const auto room = static_cast<int>((plan.exposure - 2 * margin) / plan.period);
  const int count = std::max(1, std::min({flashes, room, rig.limits.max_flashes}));
  const Duration length = plan.period * (count - 1);
  Duration first = margin;
  if (where == Where::middle) first = (plan.exposure - length) / 2;
  if (where == Where::end) first = plan.exposure - margin - length;
  for (int k = 0; k < count; ++k) plan.code.push_back({first + plan.period * k, lamps});
  return plan;
}

Fire request(const host::RigFile& rig, Lamps lamps, int flashes, Where where, const char* words) {
  Fire fire;
  fire.plan = train(rig, lamps, flashes, where);
  fire.words = words;
  fire.photograph = true;
  return fire;
}

}  // namespace

StepResult no_photograph(const std::string& id, const host::RigFile& rig) {
  return failed(
      id, "no_photograph", "no photograph of the shot came",
      fmt::format(
          "does the camera take one, and does it arrive in {} within {:.0f} s (photograph_timeout_s)?",
          rig.camera.folder.value_or("the camera's folder"), rig.analysis.photograph_timeout_s));
}

const std::vector<StepInfo>& LightStep::infos() const {
  static const std::vector<StepInfo> infos{
      {kLight, "the lamps' light on the picture", {"lamps", "camera"}},
      {kWindow, "the shutter open from first to last flash", {"shutter", "camera", "plan"}}};
  return infos;
}

std::string LightStep::briefing(const host::RigFile&) const {
  return "FLASHES, five times, each with a photograph: lamp A, lamp B, both, and both at the beginning and "
         "the end of the "
         "exposure; the machine's trigger stays still. Room dark, plate in the view. Key on, e-stop "
         "released.";
}

void LightStep::begin(const Situation& situation) {
  const host::RigFile& rig = situation.rig;
  photograph_missing_ = false;
  shots_ = ShotCollector(
      {request(rig, Lamps::a, kFlashes, Where::middle, "lamp A, with a photograph"),
       request(rig, Lamps::b, kFlashes, Where::middle, "lamp B, with a photograph"),
       request(rig, Lamps::both, kFlashes, Where::middle, "both lamps, with a photograph"),
       request(rig, Lamps::both, kFlashesAtEnds, Where::beginning, "both lamps, at the exposure's beginning"),
       request(rig, Lamps::both, kFlashesAtEnds, Where::end, "both lamps, at the exposure's end")});
}

void LightStep::on_shot(FiredShot shot) {
  if (!shot.photograph && why_unsound(shot).empty()) photograph_missing_ = true;
  shots_.add(std::move(shot));
}

Request LightStep::step(const Situation& situation) {
  if (photograph_missing_)
    return Done{
        {no_photograph(kLight, situation.rig), skipped(kWindow, "there is no photograph to judge by")}};
  if (const Fire* const wanted = shots_.next()) return *wanted;
  if (!shots_.problem().empty())
    return Done{{failed(kLight, "no_shot", shots_.problem(), "mend what it names, and run the step again"),
                 skipped(kWindow, "the shots were not fired")}};
  return Done{judge(situation)};
}

std::vector<StepResult> LightStep::judge(const Situation& situation) const {
  std::array<LitPhotograph, 5> photographs;
  for (std::size_t k = 0; k < photographs.size(); ++k) {
    const FiredShot& shot = shots_.shots()[k];
    auto read = digitize::load_photograph(*shot.photograph);
    if (!read)
      return {
          failed(kLight, "unreadable", read.error().message, "let the camera write TIFF, PNG or JPEG, whole"),
          skipped(kWindow, "a photograph could not be read")};
    photographs[k] = {std::move(*read), static_cast<int>(shot.shot.flashes.size())};
  }
  const auto light =
      measure_lamp_light({photographs[0], photographs[1], photographs[2], photographs[3], photographs[4]});
  if (!light)
    return {failed(kLight, "nothing_lit", light.error().message,
                   "then run the step again: strobe commission --only light"),
            skipped(kWindow, "nothing in the view is lit")};
  return {judge_light(kLight, *light, situation.rig.commission), judge_exposure_window(kWindow, *light)};
}

}  // namespace strobe::commission
