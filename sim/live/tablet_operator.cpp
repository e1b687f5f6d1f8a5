#include "sim/live/tablet_operator.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/well_formed.hpp"
#include "common/wire/lcm_url.hpp"

namespace strobe::sim {

namespace {

constexpr Duration kPoll = milliseconds(20);  // while an exposure lasts
constexpr Duration kIdle = std::chrono::seconds(1);
constexpr int kMaxDatagrams = 1000;  // between two looks at the tasks
// the shot's start and the shutter line's edge may coincide
constexpr Duration kStartSlack = milliseconds(1);
constexpr Duration kExposureMissing = milliseconds(5000);  // longer than any exposure
constexpr std::size_t kRememberedFrames = 256;

/// A new one for each run.
std::int64_t packets_id(const RigClock& clock) {
  std::random_device random;
  std::mt19937_64 repeatable(clock.seed());
  std::uniform_int_distribution<std::int64_t> any(1);
  return clock.seed() != 0 ? any(repeatable) : any(random);
}

}  // namespace

strobe_msgs::frame_t to_message(const reduction::Frame& frame, std::int64_t boot_id, int shot_id) {
  strobe_msgs::frame_t m = messages::frame_to_lcm(frame);
  m.boot_id = boot_id;
  m.shot_id = shot_id;
  m.source = "hand";
  return m;
}

TabletOperator::TabletOperator(const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store,
                               TruthFile& truth, std::string rig_name, const authentication::Key& key,
                               RigClock clock)
    : scene_(scene),
      seed_(seed),
      exposure_store_(exposure_store),
      truth_(truth),
      clock_(clock),
      rig_name_(std::move(rig_name)),
      seal_(key),
      packet_{packets_id(clock), 0},
      stop_event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

TabletOperator::~TabletOperator() {
  stop();
  close(stop_event_);
}

Result<std::unique_ptr<TabletOperator>> TabletOperator::create(
    const std::string& lcm_url, const std::string& rig_name, const authentication::Key& key,
    const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store, TruthFile& truth, RigClock clock) {
  std::unique_ptr<TabletOperator> tablet_operator(
      new TabletOperator(scene, seed, exposure_store, truth, rig_name, key, clock));
  if (auto joined = tablet_operator->join(lcm_url); !joined)
    return fail("cannot join LCM: " + joined.error().message + "; --no-digitizer does without");
  return tablet_operator;
}

Result<void> TabletOperator::join(const std::string& lcm_url) {
  const auto url = wire::read_lcm_url(lcm_url);
  if (!url) return tl::unexpected(url.error());
  // Wanted by its beginning: a shot's message may have several parts.
  auto socket = wire::ChannelSocket::open(
      url->group, {messages::channel_name(rig_name_, messages::Channel::shot), false, ""});
  if (!socket) return tl::unexpected(socket.error());
  socket_.emplace(std::move(*socket));
  lcm_ = std::make_unique<lcm::LCM>(wire::to_text(*url));
  if (!lcm_->good())
    return fail("LCM cannot use \"" + lcm_url +
                "\": is there a multicast route? (ip route add 224.0.0.0/4 dev lo)");
  return {};
}

void TabletOperator::start() {
  thread_ = std::thread([this] { run(); });
}

void TabletOperator::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  eventfd_write(stop_event_, 1);
  thread_.join();
}

Duration TabletOperator::until_due() const {
  MonoTime due = clock_.now() + kIdle;
  for (const Task& task : tasks_) due = std::min(due, known(task.due) ? task.due : clock_.now() + kPoll);
  return std::max(Duration{}, due - clock_.now());
}

void TabletOperator::receive() {
  socket_->stay_joined();
  pollfd awaited[] = {{socket_->fd(), POLLIN, 0}, {stop_event_, POLLIN, 0}};
  clock_.poll(awaited, 2, until_due());
  const std::string channel = messages::channel_name(rig_name_, messages::Channel::shot);
  for (int i = 0; i < kMaxDatagrams; ++i) {
    const auto received = socket_->receive();
    if (!received) return;
    const auto packet = assembler_.take(received->sender, received->bytes);
    if (!packet || packet->channel != channel) continue;
    const auto opened = seal_.open(channel, packet->data);
    strobe_msgs::shot_t shot;
    if (opened && messages::decode_checked(shot, opened->message.data(), opened->message.size()) &&
        messages::in_range(shot))
      on_shot(shot);
  }
}

void TabletOperator::on_shot(const strobe_msgs::shot_t& shot) {
  const ShotKey key{shot.boot_id, shot.shot_id};
  if (const auto known = sent_.find(key); known != sent_.end()) return publish(known->second);
  if (announced_.insert(key).second) tasks_.push_back({key, from_ns(shot.start_ns), clock_.now(), nullptr});
}

void TabletOperator::publish(const strobe_msgs::frame_t& frame) {
  const std::string channel = messages::channel_name(rig_name_, messages::Channel::frame);
  ++packet_.sequence;
  const auto packet = seal_.seal(channel, messages::encode(frame), packet_);
  lcm_->publish(channel, packet.data(), static_cast<unsigned>(packet.size()));
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
  publish(entry->second);
}

void TabletOperator::run() {
  while (!stopping_) {
    receive();
    const MonoTime now = clock_.now();
    std::erase_if(tasks_, [&](Task& task) { return process(task, now); });
  }
  for (Task& task : tasks_) {
    if (!task.exposure) find_exposure(task, task.announced + kExposureMissing);
  }
}

}  // namespace strobe::sim
