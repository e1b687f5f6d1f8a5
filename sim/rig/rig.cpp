#include "sim/rig/rig.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "common/flight/aerodynamics.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

namespace {

constexpr MonoTime kFarFuture = MonoTime::max();
constexpr Duration kSamePulse = microseconds(200);   // both lines of one pulse, set by one call or by two
constexpr Duration kReportGrace = milliseconds(20);  // edges stamped before the closing but reported after it
constexpr Duration kBallInFlight = milliseconds(5000);
constexpr Duration kBounce = microseconds(5);  // how long a bouncing line is down
constexpr int kChatter = 3;

constexpr std::size_t index(RigLine line) { return static_cast<std::size_t>(line); }
constexpr std::size_t index(Lamp lamp) { return lamp == Lamp::a ? 0 : 1; }
constexpr RigLine sensor_of(Lamp lamp) { return lamp == Lamp::a ? RigLine::sensor_a : RigLine::sensor_b; }

/// At touchdown of a ball that fell from rest, with drag along its path.
double speed_after_fall_mps(const Scene& scene, double height_m) {
  const double area_m2 = std::numbers::pi * scene.ball.radius_m() * scene.ball.radius_m();
  const double density = scene.air.density_kgpm3 < 0.0 ? flight::air_density_kgpm3(scene.air.temperature_c)
                                                       : scene.air.density_kgpm3;
  const double drag_per_m = 0.5 * density * area_m2 * scene.air.drag_coefficient / scene.ball.mass_kg;
  const double shrink = 2.0 * drag_per_m * height_m;
  const double free = 2.0 * flight::kStandardGravity_mps2 * height_m;
  return std::sqrt(shrink > 1e-9 ? free * -std::expm1(-shrink) / shrink : free);
}

}  // namespace

Rig::Rig(const Scene& scene, std::uint64_t seed, MonoTime start, const Model& model)
    : model_(model),
      scene_(reduced_scene(scene, model)),
      seed_(seed),
      lamps_{LampModel(scene_, seed, Lamp::a), LampModel(scene_, seed, Lamp::b)} {
  if (needs_calibration(scene_, model_)) {
    // If the mean ball stays on the surface, every throw is rejected likewise.
    if (const auto reduced = calibrate(scene_, model_)) reduced_ = *reduced;
  }
  restart(1, start);
}

void Rig::restart(int shot, MonoTime start) {
  for (LampModel& lamp : lamps_) lamp.restart();
  in_pulse_ = {};
  pulse_edge_ = previous_edge_ = kNoTime;
  pulses_ = 0;
  exposures_ = shot - 1;
  current_.reset();
  finished_.clear();
  shutter_draws_.reset();
  waiting_ = {};
  pending_.clear();
  levels_ = {};
  levels_[index(RigLine::key)] = scene_.chip.key_level;
  levels_[index(RigLine::estop)] = scene_.chip.estop_level;
  for (const OperatorAction& action : scene_.operator_actions)
    schedule({start + from_seconds(action.at_s), action.line, action.level});
}

void Rig::line_changed(RigLine line, int level, MonoTime at) {
  int& known = levels_[index(line)];
  if (known == level) return;
  known = level;
  switch (line) {
    case RigLine::strobe_a:
      if (level == 1) on_strobe(Lamp::a, at);
      break;
    case RigLine::strobe_b:
      if (level == 1) on_strobe(Lamp::b, at);
      break;
    case RigLine::shutter:
      on_shutter(level, at);
      break;
    case RigLine::trigger:
      if (level == 1) on_trigger(at);
      break;
    default:
      break;
  }
}

FlashPlace Rig::begin_or_join_pulse(Lamp lamp, MonoTime at) {
  const bool joins =
      known(pulse_edge_) && !in_pulse_[index(lamp)] && at - pulse_edge_ <= kSamePulse && pulses_ > 0;
  if (!joins) {
    in_pulse_ = {};
    previous_edge_ = pulses_ > 0 ? pulse_edge_ : kNoTime;
    pulse_edge_ = at;
    ++pulses_;
    if (current_) {
      current_->pulses.push_back({at, {}, {}, {}});
      most_pulses_ = std::max(most_pulses_, current_->pulses.size());
    }
  }
  in_pulse_[index(lamp)] = true;
  return {.shot = exposures_,
          .index = pulses_ - 1,
          .from_impact = scene_.faults.empty() ? std::nullopt : predict_place(pulse_edge_)};
}

std::optional<int> Rig::predict_place(MonoTime edge) const {
  if (!current_ || !current_->ball) return std::nullopt;
  const MonoTime touchdown = current_->ball->touchdown;
  if (edge >= touchdown) {
    return static_cast<int>(
        std::ranges::count_if(current_->pulses, [&](const Pulse& pulse) { return pulse.edge >= touchdown; }));
  }
  // Before touchdown: as many pulses are left as the last interval says.
  if (!known(previous_edge_) || edge <= previous_edge_) return std::nullopt;
  const Duration period = edge - previous_edge_;
  return -static_cast<int>((touchdown - edge + period - Duration{1}) / period);
}

void Rig::on_strobe(Lamp lamp, MonoTime at) {
  const FlashPlace place = begin_or_join_pulse(lamp, at);
  std::vector<FaultKind> occurred;
  LampModel& model = lamps_[index(lamp)];
  for (const MonoTime flash : model.on_pulse(at, place, occurred)) {
    const MonoTime stamp = sense(lamp, flash, place, occurred);
    if (flash_fault(scene_.faults, FaultKind::flash_dim, place, lamp)) {
      occurred.push_back(FaultKind::flash_dim);
    } else if (current_ && !current_->pulses.empty()) {
      current_->pulses.back().flashes.push_back(flash);
      ++current_->pulses.back().lamps[index(lamp)];
      current_->pulses.back().stamps.push_back(stamp);
    }
  }
  note_faults(occurred);
}

MonoTime Rig::sense(Lamp lamp, MonoTime flash, const FlashPlace& place, std::vector<FaultKind>& occurred) {
  const LampModel& model = lamps_[index(lamp)];
  if (!model.sensor_works(place.shot)) {
    occurred.push_back(FaultKind::sensor_dead);
    return kNoTime;
  }
  if (flash_fault(scene_.faults, FaultKind::sensor_dropout, place, lamp)) {
    occurred.push_back(FaultKind::sensor_dropout);
    return kNoTime;
  }
  const RigLine sensor = sensor_of(lamp);
  const MonoTime rise = flash + from_seconds(scene_.sensors.delay_s + model.sensor_jitter_s());
  const bool edge = drive_sensor(sensor, rise);
  sense_beside(lamp, rise);
  if (const Fault* bounce = flash_fault(scene_.faults, FaultKind::sensor_bounce, place, lamp)) {
    occurred.push_back(FaultKind::sensor_bounce);
    bounce_sensor(sensor, rise, bounce->delay);
  }
  return edge ? rise : kNoTime;
}

/// The other lamp's sensor, if it sees this one, too.
void Rig::sense_beside(Lamp lamp, MonoTime rise) {
  const Lamp other = lamp == Lamp::a ? Lamp::b : Lamp::a;
  const bool seen = lamp == Lamp::a ? scene_.sensors.b_sees_a : scene_.sensors.a_sees_b;
  if (seen && lamps_[index(other)].sensor_works(exposures_)) drive_sensor(sensor_of(other), rise);
}

/// Whether it made a rising edge.
bool Rig::drive_sensor(RigLine line, MonoTime rise) {
  const MonoTime fall = rise + from_seconds(scene_.sensors.pulse_s);
  // Light while the sensor still sees light makes its pulse longer, not a new edge.
  const auto overlapped = std::ranges::find_if(
      pending_, [&](const Drive& d) { return d.line == line && d.level == 0 && d.at >= rise; });
  if (overlapped == pending_.end()) {
    schedule({rise, line, 1});
    schedule({fall, line, 0});
    return true;
  }
  const MonoTime end = std::max(overlapped->at, fall);
  pending_.erase(overlapped);
  schedule({end, line, 0});
  return false;
}

void Rig::bounce_sensor(RigLine line, MonoTime rise, Duration after) {
  if (after >= from_seconds(scene_.sensors.pulse_s)) {
    drive_sensor(line, rise + after);
    return;
  }
  schedule({rise + std::max(after - kBounce, Duration{}), line, 0});
  schedule({rise + after, line, 1});
}

void Rig::on_shutter(int level, MonoTime at) {
  if (level == 1) {
    if (current_) finished_.push_back(std::move(*current_));
    ++exposures_;
    pulses_ = 0;
    current_.emplace();
    current_->pulses.reserve(most_pulses_);
    current_->shot = exposures_;
    current_->line_on = at;
    shutter_draws_.emplace(seed_, Purpose::shutter, static_cast<std::uint64_t>(exposures_));
    current_->opened = at + from_seconds(std::max(0.0, shutter_draws_->normal(scene_.shutter.open_lag_s,
                                                                              scene_.shutter.lag_sd_s)));
    if (shot_fault(scene_.faults, FaultKind::shutter_stuck, exposures_)) {
      current_->opened = kNoTime;
      note_faults({FaultKind::shutter_stuck});
    } else {
      schedule({current_->opened, RigLine::xsync, 1});
      if (scene_.shutter.longest_open_s > 0.0)
        schedule({current_->opened + from_seconds(scene_.shutter.longest_open_s), RigLine::xsync, 0});
    }
    if (known(waiting_.triggered) && at - waiting_.triggered < kBallInFlight) {
      current_->ball = std::move(waiting_.ball);
      current_->more_balls = std::move(waiting_.more_balls);
      current_->throws = waiting_.throws;
      note_faults(waiting_.faults);
    } else {
      drop_by_hand();
    }
    waiting_ = {};
  } else if (current_ && !known(current_->closed)) {
    release_shutter(at);
  }
}

void Rig::release_shutter(MonoTime at) {
  if (at < current_->opened) {
    std::erase_if(pending_, [](const Drive& drive) { return drive.line == RigLine::xsync; });
    current_->opened = kNoTime;
    current_->closed = at;
    return;
  }
  current_->closed = at + from_seconds(std::max(0.0, shutter_draws_->normal(scene_.shutter.close_lag_s,
                                                                            scene_.shutter.lag_sd_s)));
  if (!known(current_->opened)) return;
  if (scene_.shutter.longest_open_s > 0.0) {
    const MonoTime by_itself = current_->opened + from_seconds(scene_.shutter.longest_open_s);
    if (by_itself <= current_->closed) {
      current_->closed = by_itself;
      return;
    }
    std::erase_if(pending_,
                  [](const Drive& drive) { return drive.line == RigLine::xsync && drive.level == 0; });
  }
  schedule({current_->closed, RigLine::xsync, 0});
}

/// Straight down, which across an inclined plate is not along its normal.
void Rig::drop_by_hand() {
  const HandSettings& hand = scene_.hand;
  if (hand.drop_height_m <= 0.0 || !known(current_->opened)) return;
  ShotConditions dropped = draw_shot_conditions(scene_, seed_, current_->shot);
  const double speed_mps = speed_after_fall_mps(scene_, hand.drop_height_m);
  dropped.touchdown = {-speed_mps * std::sin(scene_.surface_angle_rad),
                       -speed_mps * std::cos(scene_.surface_angle_rad), 0.0};
  dropped.vz_mps = dropped.omega_x_radps = dropped.omega_y_radps = 0.0;
  dropped.spot_m = shutter_draws_->normal(0.0, hand.spot_sd_m);
  const double slower_mps =
      speed_mps - std::abs(scene_.machine.speed_mps * std::sin(scene_.machine.angle_rad));
  dropped.coefficients.e =
      std::clamp(dropped.coefficients.e + scene_.bounce.e_slope_spm * slower_mps, 0.05, 0.99);
  auto path = BallPath::make(scene_, dropped, model_);
  if (!path) return;
  const MonoTime touchdown = current_->opened + from_seconds(hand.touchdown_s);
  const double fall_s = 2.0 * hand.drop_height_m / speed_mps;
  current_->ball = ThrownBall{std::move(*path), touchdown, touchdown - from_seconds(fall_s)};
}

void Rig::on_trigger(MonoTime at) {
  const bool during_exposure = current_ && !known(current_->closed);
  const int shot = during_exposure ? current_->shot : exposures_ + 1;
  std::optional<ThrownBall> ball;
  std::vector<ThrownBall> more_balls;
  int throws = 0;
  std::vector<FaultKind> occurred;
  if (shot_fault(scene_.faults, FaultKind::machine_misfire, shot)) {
    occurred.push_back(FaultKind::machine_misfire);
  } else {
    throws = 1;
    const ShotConditions thrown = draw_shot_conditions(scene_, seed_, shot);
    const MonoTime touchdown = at + from_seconds(thrown.lag_s);
    for (const FaultKind kind : {FaultKind::gate_chatter, FaultKind::gate_dead})
      if (shot_fault(scene_.faults, kind, shot)) occurred.push_back(kind);
    if (auto path = BallPath::make(scene_, thrown, model_, reduced_ ? &*reduced_ : nullptr)) {
      if (gate_watched_) drive_gate(*path, touchdown, at, shot);
      ball = ThrownBall{std::move(*path), touchdown};
      if (const Fault* twice = shot_fault(scene_.faults, FaultKind::machine_double, shot)) {
        occurred.push_back(FaultKind::machine_double);
        throws = 2;
        if (gate_watched_) drive_gate(ball->path, touchdown + twice->delay, at, shot);
        more_balls.push_back({ball->path, touchdown + twice->delay});
      }
    }
    if (shot_fault(scene_.faults, FaultKind::ball_misses, shot)) {
      occurred.push_back(FaultKind::ball_misses);
      ball.reset();
      more_balls.clear();
    }
  }
  if (during_exposure) {
    current_->throws += throws;
    const bool by_hand = current_->ball && current_->ball->released != MonoTime::min();
    if (!current_->ball || (by_hand && ball)) current_->ball = std::move(ball);
    std::ranges::move(more_balls, std::back_inserter(current_->more_balls));
    note_faults(occurred);
  } else {
    if (known(waiting_.triggered) && at - waiting_.triggered > kBallInFlight) waiting_ = {};
    waiting_.triggered = at;
    waiting_.throws += throws;
    if (!waiting_.ball) waiting_.ball = std::move(ball);
    std::ranges::move(more_balls, std::back_inserter(waiting_.more_balls));
    waiting_.faults.insert(waiting_.faults.end(), occurred.begin(), occurred.end());
  }
}

void Rig::drive_gate(const BallPath& path, MonoTime touchdown, MonoTime trigger, int shot) {
  const double radius_m = scene_.ball.radius_m();
  const double centre_m = scene_.gate.distance_m + path.spot_m();
  const auto enters_s = path.time_at_distance_s(centre_m + radius_m);
  const auto leaves_s = path.time_at_distance_s(centre_m - radius_m);
  if (!enters_s || !leaves_s) return;
  const MonoTime rise = touchdown + from_seconds(*enters_s);
  const MonoTime fall = touchdown + from_seconds(*leaves_s);
  if (shot_fault(scene_.faults, FaultKind::gate_dead, shot)) return;
  if (rise <= trigger) return;  // the machine stands on the plate's side of the beam
  schedule({rise, RigLine::gate, 1});
  schedule({fall, RigLine::gate, 0});
  const Fault* chatter = shot_fault(scene_.faults, FaultKind::gate_chatter, shot);
  for (int k = 1; chatter != nullptr && k <= kChatter; ++k) {
    const MonoTime early = rise - chatter->delay * k;
    if (early <= trigger) break;
    schedule({early, RigLine::gate, 1});
    schedule({early + chatter->delay / 2, RigLine::gate, 0});
  }
}

void Rig::schedule(const Drive& drive) {
  const auto place = std::ranges::find_if(pending_, [&](const Drive& d) { return d.at <= drive.at; });
  pending_.insert(place, drive);
}

void Rig::note_faults(const std::vector<FaultKind>& kinds) {
  if (!current_) return;
  for (const FaultKind kind : kinds) {
    if (!current_->has(kind)) current_->faults.push_back(kind);
  }
}

MonoTime Rig::next_due() const {
  MonoTime due = pending_.empty() ? kFarFuture : pending_.back().at;
  if (current_ && known(current_->closed)) due = std::min(due, current_->closed + kReportGrace);
  if (!finished_.empty()) due = std::min(due, finished_.front().closed);
  return due;
}

void Rig::collect(MonoTime now, std::vector<Drive>& drives, std::vector<Exposure>& exposures) {
  while (!pending_.empty() && pending_.back().at <= now) {
    drives.push_back(pending_.back());
    pending_.pop_back();
  }
  if (current_ && known(current_->closed) && current_->closed + kReportGrace <= now) {
    finished_.push_back(std::move(*current_));
    current_.reset();
    pulses_ = 0;
  }
  std::ranges::move(finished_, std::back_inserter(exposures));
  finished_.clear();
}

void Rig::finish(MonoTime now, std::vector<Exposure>& exposures) {
  if (current_) {
    if (!known(current_->closed)) on_shutter(0, now);
    finished_.push_back(std::move(*current_));
    current_.reset();
  }
  std::ranges::move(finished_, std::back_inserter(exposures));
  finished_.clear();
}

std::optional<MonoTime> Rig::exposing_since() const {
  if (!current_) return std::nullopt;
  return current_->line_on;
}

}  // namespace strobe::sim
