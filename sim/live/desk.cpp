#include "sim/live/desk.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/messages/channels.hpp"
#include "sim/live/runner.hpp"

namespace strobe::sim {

namespace {

constexpr int kPoll_ms = 10;
constexpr Duration kStartSlack =
    milliseconds(1);  // the shot's start and the shutter line's edge may coincide
constexpr Duration kExposureMissing = milliseconds(5000);  // longer than any exposure
constexpr std::size_t kRememberedFrames = 256;

Duration from_seconds(double s) { return nanoseconds(std::llround(s * 1e9)); }

double or_nan(const std::optional<double>& value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

std::int8_t leg_code(const std::optional<reduction::Leg>& leg) {
  using strobe_msgs::ball_image_t;
  if (!leg) return ball_image_t::LEG_UNKNOWN;
  switch (*leg) {
    case reduction::Leg::incoming:
      return ball_image_t::LEG_INCOMING;
    case reduction::Leg::contact:
      return ball_image_t::LEG_CONTACT;
    case reduction::Leg::rebound:
      return ball_image_t::LEG_REBOUND;
  }
  return ball_image_t::LEG_UNKNOWN;
}

strobe_msgs::ball_image_t to_message(const reduction::BallImage& image) {
  strobe_msgs::ball_image_t m{};
  m.leg = leg_code(image.leg);
  m.centre_x_px = image.centre_px.x;
  m.centre_y_px = image.centre_px.y;
  m.diameter_px = image.diameter_px;
  m.equator_rad = or_nan(image.equator_rad);
  m.top_x_px = image.top_px ? image.top_px->x : or_nan(std::nullopt);
  m.top_y_px = image.top_px ? image.top_px->y : or_nan(std::nullopt);
  return m;
}

}  // namespace

strobe_msgs::frame_t to_message(const reduction::Frame& frame, std::int64_t boot_id, int shot_id) {
  strobe_msgs::frame_t m{};
  m.schema_version = strobe_msgs::frame_t::SCHEMA_VERSION;
  m.boot_id = boot_id;
  m.shot_id = shot_id;
  m.source = "hand";
  m.centre_sd_px = or_nan(frame.centre_sd_px);
  m.diameter_sd_px = or_nan(frame.diameter_sd_px);
  m.surface_sd_px = or_nan(frame.surface_sd_px);
  m.equator_sd_rad = or_nan(frame.equator_sd_rad);
  m.px_per_m = or_nan(frame.px_per_m);
  m.px_per_m_sd = or_nan(frame.px_per_m_sd);
  for (const reduction::PointPx& p : frame.surface_px) {
    strobe_msgs::point_t point{};
    point.x_px = p.x;
    point.y_px = p.y;
    m.surface.push_back(point);
  }
  m.surface_count = static_cast<std::int32_t>(m.surface.size());
  for (const reduction::BallImage& image : frame.images) m.images.push_back(to_message(image));
  m.image_count = static_cast<std::int32_t>(m.images.size());
  return m;
}

Desk::Desk(const Scene& scene, std::uint64_t seed, Darkroom& darkroom, TruthFile& truth, std::string rig_name)
    : scene_(scene), seed_(seed), darkroom_(darkroom), truth_(truth), rig_name_(std::move(rig_name)) {}

Desk::~Desk() { stop(); }

Result<std::unique_ptr<Desk>> Desk::create(const std::string& lcm_url, const std::string& rig_name,
                                           const Scene& scene, std::uint64_t seed, Darkroom& darkroom,
                                           TruthFile& truth) {
  std::unique_ptr<Desk> desk(new Desk(scene, seed, darkroom, truth, rig_name));
  desk->lcm_ = std::make_unique<lcm::LCM>(lcm_url);
  if (!desk->lcm_->good())
    return fail("cannot join LCM at " + lcm_url +
                " (is there a multicast route?); --no-digitizer does without");
  lcm::Subscription* subscription = desk->lcm_->subscribe(
      messages::channel_name(rig_name, messages::Channel::shot), &Desk::on_shot, desk.get());
  subscription->setQueueCapacity(messages::kSubscriptionQueueCapacity);
  return desk;
}

void Desk::start() {
  thread_ = std::thread([this] { run(); });
}

void Desk::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
}

void Desk::on_shot(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::shot_t* shot) {
  const ShotKey key{shot->boot_id, shot->shot_id};
  if (const auto known = sent_.find(key); known != sent_.end()) {
    lcm_->publish(messages::channel_name(rig_name_, messages::Channel::frame), &known->second);
    return;
  }
  if (announced_.insert(key).second)
    tasks_.push_back({key, MonoTime{shot->start_ns}, monotonic_now(), nullptr});
}

bool Desk::find_exposure(Task& task, MonoTime now) {
  const Darkroom::Found found = darkroom_.begun_within(task.shot_start - kStartSlack, task.announced);
  if (found.wait && now - task.announced < kExposureMissing) return false;
  task.exposure = found.exposure ? found.exposure : std::make_shared<const Exposure>();
  truth_.write(*task.exposure, task.key.second);
  const Fault* late = shot_fault(scene_.faults, FaultKind::frame_late, task.exposure->shot);
  task.due =
      task.announced + from_seconds(scene_.tablet.digitize_delay_s) + (late ? late->delay : Duration{});
  return true;
}

bool Desk::attend(Task& task, MonoTime now) {
  if (!task.exposure && !find_exposure(task, now)) return false;
  const bool photograph = task.exposure->opened.known() &&
                          !shot_fault(scene_.faults, FaultKind::no_photograph, task.exposure->shot);
  if (photograph && now < task.due) return false;
  if (photograph) send(task);
  return true;
}

void Desk::send(const Task& task) {
  const Digitized digitized = digitize(scene_, seed_, *task.exposure);
  if (sent_.size() >= kRememberedFrames) sent_.erase(sent_.begin());
  const auto [entry, inserted] =
      sent_.insert_or_assign(task.key, to_message(digitized.frame, task.key.first, task.key.second));
  lcm_->publish(messages::channel_name(rig_name_, messages::Channel::frame), &entry->second);
}

void Desk::run() {
  while (!stopping_) {
    lcm_->handleTimeout(kPoll_ms);
    const MonoTime now = monotonic_now();
    std::erase_if(tasks_, [&](Task& task) { return attend(task, now); });
  }
  for (Task& task : tasks_) {
    if (!task.exposure) find_exposure(task, task.announced + kExposureMissing);
  }
}

}  // namespace strobe::sim
