#include "tests/soak/tablet_operator.hpp"

#include <strobe_msgs/frame_t.hpp>

#include "common/messages/lcm_conversions.hpp"
#include "sim/rig/tablet.hpp"

namespace strobe::soak {

namespace {

constexpr Duration kStartSlack = milliseconds(1);
constexpr Duration kLookAgain = milliseconds(50);
constexpr Duration kExposureMissing = milliseconds(5000);  // longer than any exposure

}  // namespace

void VirtualTabletOperator::add(sim::Exposure exposure) {
  exposures_.push_back(std::make_shared<const sim::Exposure>(std::move(exposure)));
}

const sim::Exposure* VirtualTabletOperator::exposure_of(MonoTime shot_start, MonoTime shot_end) const {
  for (const auto& exposure : exposures_)
    if (exposure->line_on >= shot_start - kStartSlack && exposure->line_on <= shot_end) return exposure.get();
  return nullptr;
}

void VirtualTabletOperator::announce(ShotKey key, MonoTime start, MonoTime now) {
  const bool news = announced_.emplace(key, now).second;
  if (!news && !measured_.contains(key)) return;
  tasks_.schedule(news ? now + from_seconds(scene_.tablet.digitize_delay_s) : now,
                  {key, start, announced_.at(key)});
}

std::vector<std::uint8_t> VirtualTabletOperator::take(MonoTime now) {
  const Task task = tasks_.take().item;
  if (const auto sent = measured_.find(task.key); sent != measured_.end()) return sent->second;
  const sim::Exposure* exposure = exposure_of(task.start, task.announced);
  if (exposure == nullptr) {
    if (now - task.announced < kExposureMissing) tasks_.schedule(now + kLookAgain, task);
    return {};
  }
  if (!known(exposure->opened) || shot_fault(scene_.faults, sim::FaultKind::no_photograph, exposure->shot))
    return {};
  const sim::Fault* late = shot_fault(scene_.faults, sim::FaultKind::frame_late, exposure->shot);
  const MonoTime due =
      task.announced + from_seconds(scene_.tablet.digitize_delay_s) + (late ? late->delay : Duration{});
  if (now < due) {
    tasks_.schedule(due, task);
    return {};
  }
  reduction::Frame frame = sim::digitize(scene_, seed_, *exposure).frame;
  frame.shot_id = task.key.shot_id;
  strobe_msgs::frame_t message = messages::frame_to_lcm(frame);
  message.boot_id = task.key.boot_id;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  measured_[task.key] = bytes;
  return bytes;
}

}  // namespace strobe::soak
