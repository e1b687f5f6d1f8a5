#include "host/commission/core/shot_collector.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/reduction/flags.hpp"

namespace strobe::commission {
namespace {

bool issued_late(const strobe_msgs::shot_t& shot) {
  return std::ranges::any_of(shot.flashes, [&](const strobe_msgs::flash_t& flash) {
    const MonoTime issued = from_ns(flash.issue_end_ns);
    return !known(issued) || to_microseconds(issued - from_ns(flash.commanded_ns)) > shot.late_tolerance_us;
  });
}

}  // namespace

std::string why_unsound(const FiredShot& fired) {
  const strobe_msgs::shot_t& shot = fired.shot;
  if (shot.aborted) return "the shot was aborted: " + shot.abort_reason;
  if (shot.queue_overflows > 0 || shot.kernel_overflows > 0) return "edges were lost in the shot";
  if (fired.result.readout.flags.has(reduction::Flag::events_missing))
    return "events of the shot did not come";
  if (issued_late(shot)) return "the rig's machine issued a flash late";
  return "";
}

const Fire* ShotCollector::next() const {
  return problem_.empty() && shots_.size() < wanted_.size() ? &wanted_[shots_.size()] : nullptr;
}

void ShotCollector::add(FiredShot shot) {
  const std::string why = why_unsound(shot);
  if (why.empty()) {
    shots_.push_back(std::move(shot));
  } else if (++repeated_ > kRetries) {
    problem_ = fmt::format("{} shots in this step were of no use; of the last one {}", repeated_, why);
  }
}

}  // namespace strobe::commission
