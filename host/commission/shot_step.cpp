#include "host/commission/shot_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <exception>

#include "common/reduction/flags.hpp"
#include "host/assembly/assemble.hpp"

namespace strobe::commission {
namespace {

bool issued_late(const strobe_msgs::shot_t& shot) {
  return std::ranges::any_of(shot.flashes, [&](const strobe_msgs::flash_t& flash) {
    const MonoTime issued = from_ns(flash.issue_end_ns);
    return !known(issued) || to_microseconds(issued - from_ns(flash.commanded_ns)) > shot.late_tolerance_us;
  });
}

/// Absent: the photograph is of no use.
std::optional<host::MeasuredPhotograph> measured(const std::filesystem::path& file, const host::RigFile& rig,
                                                 std::vector<double> flash_times_s) {
  host::MeasureSettings settings;
  settings.flash_times_s = std::move(flash_times_s);
  try {
    auto found = host::measure_photograph(file, rig, settings);
    if (found) return std::move(*found);
  } catch (const std::exception&) {  // of OpenCV, out of memory
  }
  return std::nullopt;
}

StepResult no_photograph(const host::RigFile& rig) {
  return failed(
      "no_photograph", "no photograph of the shot came",
      fmt::format(
          "does the camera take one, and does it arrive in {} within {:.0f} s (photograph_timeout_s)?",
          rig.camera.folder.value_or("the camera's folder"), rig.analysis.photograph_timeout_s));
}

}  // namespace

std::string why_unsound(const host::Shot& fired) {
  const strobe_msgs::shot_t& shot = *fired.summary;
  if (shot.aborted) return "the shot was aborted: " + shot.abort_reason;
  if (shot.queue_overflows > 0 || shot.kernel_overflows > 0) return "edges were lost in the shot";
  if (fired.readout.flags.has(reduction::Flag::events_missing)) return "events of the shot did not come";
  if (issued_late(shot)) return "the rig's computer issued a flash late";
  return "";
}

ShotPlan dry_train(const host::RigFile& rig, Lamps lamps, int flashes) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(rig.plan.even.period, rig.limits.lamp_period);
  const auto room = static_cast<int>(rig.limits.longest_exposure / plan.period) - 1;
  const int count = std::clamp(
      flashes, 1, std::max(1, std::min({room, rig.limits.max_flashes, static_cast<int>(kMaxCodedFlashes)})));
  for (int k = 0; k < count; ++k) plan.code.push_back({plan.period * k, lamps});
  plan.exposure = plan.period * (count + 1);
  plan.impact_at = plan.exposure / 2;
  return plan;
}

StepResult no_shot(const std::string& why) {
  return failed("no_shot", why, "mend what it names, and run the step again");
}

void ShotStep::begin(const Situation& situation) {
  rig_ = &situation.rig;
  wanted_ = shots(*rig_);
  shots_.clear();
  measuring_.clear();
  repeated_ = missing_ = 0;
  problem_.clear();
}

void ShotStep::on_shot(host::Shot shot) {
  assert(rig_ != nullptr);
  if (const std::string why = why_unsound(shot); !why.empty()) {
    if (++repeated_ > kRetries)
      problem_ = fmt::format("{} shots in this step were of no use; of the last one {}", repeated_, why);
    return;
  }
  on_sound_shot();
  if (!shot.photograph) ++missing_;
  if (shot.photograph && photographs_.measure) {
    std::shared_future<Measured> before;
    if (!measuring_.empty()) before = measuring_.back().second;
    auto task = [before, file = *shot.photograph, rig = *rig_, times = host::flash_times_s(*shot.summary)] {
      if (before.valid()) before.wait();
      return measured(file, rig, times);
    };
    measuring_.emplace_back(shots_.size(), std::async(std::launch::async, std::move(task)).share());
  }
  shots_.push_back({std::move(shot), std::nullopt});
}

Request ShotStep::step(const Situation& situation) {
  if (photographs_.missing > 0 && missing_ >= photographs_.missing)
    return Done{nothing_judged(no_photograph(situation.rig), "there is no photograph to judge by")};
  if (problem_.empty() && shots_.size() < wanted_.size()) return wanted_[shots_.size()];
  if (!problem_.empty()) return Done{nothing_judged(no_shot(problem_), "the shots were not fired")};
  for (const auto& [shot, photograph] : measuring_)
    if (photograph.wait_for(std::chrono::seconds{0}) != std::future_status::ready)
      return Wait{"the photographs are being measured"};
  for (const auto& [shot, photograph] : measuring_) shots_[shot].measured = photograph.get();
  measuring_.clear();
  return Done{judge(shots_, situation.rig)};
}

std::vector<StepResult> ShotStep::nothing_judged(StepResult first, const std::string& why) const {
  std::vector<StepResult> results(infos().size(), left_out(why));
  results.front() = std::move(first);
  return results;
}

}  // namespace strobe::commission
