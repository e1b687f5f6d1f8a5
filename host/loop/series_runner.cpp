#include "host/loop/series_runner.hpp"

#include <exception>
#include <utility>

namespace strobe::host {
namespace {

// The first status may take half of it: nothing is missing before it had time to come.
constexpr Duration kFirstStatus = std::chrono::seconds{1};
constexpr Duration kDisarmTimeout = std::chrono::seconds{10};

}  // namespace

SeriesRunner::SeriesRunner(HostLoop& loop, ShotSeriesSettings settings)
    : loop_(loop), series_(std::move(settings), loop.commands()), entered_(loop.now()) {
  loop.add_listener(*this);
}

void SeriesRunner::enter(Phase phase) {
  phase_ = phase;
  entered_ = loop_.now();
  if (phase == Phase::recovering) recovery_.emplace(loop_.now());
}

void SeriesRunner::take_in_first(FormerRuns former) {
  resumption_.emplace(loop_, std::move(former));
  enter(Phase::taking_in);
}

void SeriesRunner::on_shot_result(const Shot& result) {
  if (result.host_id == loop_.settings().host_id) {
    series_.on_shot_result(result);
  } else if (loop_.session().adopted(result.host_id)) {
    series_.on_former_result(result);
  }
}

void SeriesRunner::step() {
  if (phase_ == Phase::taking_in && resumption_->finished()) enter(Phase::firing);
  if (phase_ == Phase::firing) send_commands();  // what a message has led to since
  if (phase_ == Phase::firing && series_.finished())
    enter(loop_.disarming() ? Phase::disarming : Phase::recovering);
  if (phase_ == Phase::disarming && (!loop_.disarming() || loop_.now() - entered_ > kDisarmTimeout))
    enter(Phase::recovering);
  if (phase_ == Phase::firing) {
    if (on_begin_) std::exchange(on_begin_, nullptr)();
    fire();
  }
  if (phase_ == Phase::recovering && (hurried_ || recovery_->finished(loop_.session(), loop_.now())))
    phase_ = Phase::finished;
}

void SeriesRunner::fire() {
  const auto status = loop_.live_status();
  const Session& session = loop_.session();
  series_.on_danger(session.danger());
  if (loop_.was_suspended()) series_.end_after_shot("this computer was suspended");
  series_.on_second_rig(loop_.second_rig());
  series_.on_unanswered(loop_.unanswered());
  if (const PhotographPipeline* photographs = loop_.photographs())
    series_.on_camera(photographs->camera_problem(loop_.now()), photographs->stamped());
  if (status)
    series_.on_arming_of(session.host_name(status->arm_host_id), session.adopted(status->arm_host_id));
  // One that was fired at the last moment of an earlier run.
  const bool former_under_way = status && session.waits_for_adopted() && !series_.shot_under_way();
  if (!former_under_way && (status || loop_.now() - entered_ > kFirstStatus))
    series_.step(status, loop_.now());
  send_commands();
}

bool SeriesRunner::stop(const std::string& by) {
  if (phase_ != Phase::firing && phase_ != Phase::taking_in) return false;
  series_.stop();
  loop_.disarm(by);
  enter(Phase::disarming);
  return true;
}

void SeriesRunner::stop_at_once(const std::string& by) {
  hurried_ = true;
  if (stop(by) || phase_ == Phase::finished) return;
  loop_.disarm(by);
  enter(Phase::disarming);
}

void SeriesRunner::leave() { phase_ = Phase::finished; }

void SeriesRunner::end_after_shot(const std::string& why) {
  if (phase_ != Phase::firing && phase_ != Phase::taking_in) return;
  series_.end_after_shot(why);
  send_commands();
}

void SeriesRunner::send_commands() {
  for (const auto& command : series_.take_commands()) loop_.send(command);
  for (const std::string& text : series_.take_notifications()) loop_.notify(text);
  if (series_.take_disarm()) loop_.disarm("this run, as its series has ended");
}

Duration SeriesRunner::recovering_for() const {
  return phase_ == Phase::recovering ? loop_.now() - entered_ : Duration{};
}

namespace {

// What cannot be written is told within a second; what has vanished is looked for as often.
constexpr Duration kTendEvery = milliseconds{500};

}  // namespace

StoredSeries::StoredSeries(const HostLoopSettings& settings, const ShotSeriesSettings& series,
                           SessionFolder& folder, Transport& transport, Clock& clock)
    : folder_(folder),
      clock_(clock),
      transport_(transport, folder, clock),
      loop_(settings, transport_, clock),
      runner_(loop_, series) {
  loop_.add_listener(*this);
  if (!settings.key) return;
  auto former = read_former_runs(folder.path(), settings.rig, *settings.key, folder.log_path());
  if (!former) {
    former_error_ = former.error();
    return;
  }
  for (const auto& [key, shot] : former->shots) folder.add(shot);
  if (!former->empty() || !former->events.empty()) runner_.take_in_first(std::move(*former));
}

void StoredSeries::on_shot_result(const Shot& result) {
  if (result.host_id != loop_.settings().host_id && !loop_.session().adopted(result.host_id)) return;
  if (!result.dry) folder_.add(result, utc_for_table(clock_.read().wall));
  unsynced_ = true;
}

void StoredSeries::on_shot(const strobe_msgs::shot_t& shot) { folder_.add(shot); }

void StoredSeries::on_camera(const tether::OpenedEvent& camera) {
  folder_.add_camera(tether::to_line(camera), utc_for_table(clock_.read().wall));
}

void StoredSeries::on_not_kept(const std::string& what) {
  not_kept_.push_back(what);
  runner_.end_after_shot(what);
}

void StoredSeries::tell_failures() {
  for (const std::string& failure : folder_.take_failures()) {
    loop_.notify(failure);
    runner_.end_after_shot(failure);
  }
}

bool StoredSeries::run_once() {
  const bool receiving = loop_.run_once();
  if (receiving) step();
  return receiving;
}

void StoredSeries::step() {
  if (std::exchange(unsynced_, false)) folder_.sync();
  if (loop_.now() - tended_ >= kTendEvery) {
    folder_.tend();
    tended_ = loop_.now();
  }
  tell_failures();  // before the series goes on
  runner_.step();
}

void StoredSeries::close() {
  folder_.close();
  tell_failures();
}

void StoredSeries::abandon() noexcept {
  try {
    runner_.stop("this run, as it ended with an error");
  } catch (const std::exception&) {  // its arming expires by itself
  }
  try {
    folder_.close();
  } catch (const std::exception&) {  // what was written is with the system
  }
}

std::vector<std::string> StoredSeries::unstored() const {
  std::vector<std::string> lines = folder_.unstored();
  lines.insert(lines.end(), not_kept_.begin(), not_kept_.end());
  return lines;
}

}  // namespace strobe::host
