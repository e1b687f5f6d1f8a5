#include "host/loop/stored_series.hpp"

#include <exception>

namespace strobe::host {
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

void StoredSeries::on_shot_result(const ShotResult& result) {
  if (result.host_id != loop_.settings().host_id && !loop_.session().adopted(result.host_id)) return;
  if (!result.dry) folder_.add(result, utc_for_table(clock_.read().wall));
  unsynced_ = true;
}

void StoredSeries::on_shot(const strobe_msgs::shot_t& shot) { folder_.add(shot); }

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
    runner_.stop("the end by an error");
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
