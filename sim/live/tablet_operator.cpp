#include "sim/live/tablet_operator.hpp"

#include <algorithm>
#include <cmath>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "sim/live/rig_runner.hpp"

namespace strobe::sim {

namespace {

constexpr int kPoll_ms = 10;
// the shot's start and the shutter line's edge may coincide
constexpr Duration kStartSlack = milliseconds(1);
constexpr Duration kExposureMissing = milliseconds(5000);  // longer than any exposure
constexpr std::size_t kRememberedFrames = 256;

}  // namespace

strobe_msgs::frame_t to_message(const reduction::Frame& frame, std::int64_t boot_id, int shot_id) {
  strobe_msgs::frame_t m = messages::frame_to_lcm(frame);
  m.boot_id = boot_id;
  m.shot_id = shot_id;
  m.source = "hand";
  return m;
}

TabletOperator::TabletOperator(const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store,
                               TruthFile& truth, std::string rig_name)
    : scene_(scene),
      seed_(seed),
      exposure_store_(exposure_store),
      truth_(truth),
      rig_name_(std::move(rig_name)) {}

TabletOperator::~TabletOperator() { stop(); }

Result<std::unique_ptr<TabletOperator>> TabletOperator::create(const std::string& lcm_url,
                                                               const std::string& rig_name,
                                                               const Scene& scene, std::uint64_t seed,
                                                               ExposureStore& exposure_store,
                                                               TruthFile& truth) {
  std::unique_ptr<TabletOperator> tablet_operator(
      new TabletOperator(scene, seed, exposure_store, truth, rig_name));
  tablet_operator->lcm_ = std::make_unique<lcm::LCM>(lcm_url);
  if (!tablet_operator->lcm_->good())
    return fail("cannot join LCM at " + lcm_url +
                " (is there a multicast route?); --no-digitizer does without");
  lcm::Subscription* subscription =
      tablet_operator->lcm_->subscribe(messages::channel_name(rig_name, messages::Channel::shot),
                                       &TabletOperator::on_shot, tablet_operator.get());
  subscription->setQueueCapacity(messages::kSubscriptionQueueCapacity);
  return tablet_operator;
}

void TabletOperator::start() {
  thread_ = std::thread([this] { run(); });
}

void TabletOperator::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
}

void TabletOperator::on_shot(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::shot_t* shot) {
  const ShotKey key{shot->boot_id, shot->shot_id};
  if (const auto known = sent_.find(key); known != sent_.end()) {
    lcm_->publish(messages::channel_name(rig_name_, messages::Channel::frame), &known->second);
    return;
  }
  if (announced_.insert(key).second)
    tasks_.push_back({key, from_ns(shot->start_ns), monotonic_now(), nullptr});
}

bool TabletOperator::find_exposure(Task& task, MonoTime now) {
  const ExposureStore::Found found =
      exposure_store_.begun_within(task.shot_start - kStartSlack, task.announced);
  if (found.wait && now - task.announced < kExposureMissing) return false;
  task.exposure = found.exposure ? found.exposure : std::make_shared<const Exposure>();
  truth_.write(*task.exposure, task.key.shot_id);
  const Fault* late = shot_fault(scene_.faults, FaultKind::frame_late, task.exposure->shot);
  task.due =
      task.announced + from_seconds(scene_.tablet.digitize_delay_s) + (late ? late->delay : Duration{});
  return true;
}

bool TabletOperator::process(Task& task, MonoTime now) {
  if (!task.exposure && !find_exposure(task, now)) return false;
  const bool photograph = sends_ && known(task.exposure->opened) &&
                          !shot_fault(scene_.faults, FaultKind::no_photograph, task.exposure->shot);
  if (photograph && now < task.due) return false;
  if (photograph) send(task);
  return true;
}

void TabletOperator::send(const Task& task) {
  const Digitized digitized = digitize(scene_, seed_, *task.exposure);
  if (sent_.size() >= kRememberedFrames) sent_.erase(sent_.begin());
  const auto [entry, inserted] =
      sent_.insert_or_assign(task.key, to_message(digitized.frame, task.key.boot_id, task.key.shot_id));
  lcm_->publish(messages::channel_name(rig_name_, messages::Channel::frame), &entry->second);
}

void TabletOperator::run() {
  while (!stopping_) {
    lcm_->handleTimeout(kPoll_ms);
    const MonoTime now = monotonic_now();
    std::erase_if(tasks_, [&](Task& task) { return process(task, now); });
  }
  for (Task& task : tasks_) {
    if (!task.exposure) find_exposure(task, task.announced + kExposureMissing);
  }
}

}  // namespace strobe::sim
