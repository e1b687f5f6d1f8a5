#include "host/photographs/photograph_pipeline.hpp"

#include <fmt/format.h>

#include <system_error>

#include "common/messages/lcm_conversions.hpp"
#include "host/assembly/flash_times.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxShots = 200;

std::vector<double> seconds_of(const FlashTimes& times) {
  std::vector<double> seconds;
  if (!times.in_order) return seconds;
  for (const ObservedFlash& flash : times.seen)
    seconds.push_back(static_cast<double>(flash.time_ns - times.seen.front().time_ns) * 1e-9);
  return seconds;
}

}  // namespace

PhotographPipeline::PhotographPipeline(MessageHandler& next, std::unique_ptr<CameraFolder> folder,
                                       MeasurePhotograph measure, PhotographSettings settings)
    : next_(next),
      folder_(std::move(folder)),
      settings_(std::move(settings)),
      match_(settings_.timeout_s),
      reader_(std::move(measure), settings_.retry_timeout_s) {}

void PhotographPipeline::status(const strobe_msgs::status_t& message, std::int64_t now_ns) {
  match_.on_heartbeat(message.boot_id, {message.mono_ns, message.wall_ns, message.boot_time_ns}, now_ns);
  next_.status(message, now_ns);
}

void PhotographPipeline::event(const strobe_msgs::event_t& message, std::int64_t now_ns) {
  next_.event(message, now_ns);
}

void PhotographPipeline::shot(const strobe_msgs::shot_t& message, std::int64_t now_ns) {
  match_.on_shot(message);
  const ShotKey key{message.boot_id, message.shot_id};
  if (flash_times_s_.size() >= kMaxShots) flash_times_s_.erase(flash_times_s_.begin());
  flash_times_s_[key] = seconds_of(flash_times(message));
  next_.shot(message, now_ns);
}

void PhotographPipeline::frame(const strobe_msgs::frame_t& message, std::int64_t now_ns) {
  match_.on_measured({message.boot_id, message.shot_id});
  next_.frame(message, now_ns);
}

void PhotographPipeline::turn(std::int64_t now_ns) {
  for (const Arrival& arrival : folder_->look(now_ns)) arrive(arrival);
  for (std::string& text : folder_->take_notifications()) notify(std::move(text));
  for (PhotographResult& result : reader_.take_results()) finish(std::move(result));
  for (const PhotographDecision& decision : match_.decide(now_ns)) follow(decision);
}

void PhotographPipeline::end(std::int64_t now_ns) {
  turn(now_ns);
  for (const PhotographDecision& decision : match_.end(now_ns)) follow(decision);
}

void PhotographPipeline::arrive(const Arrival& arrival) {
  if (under_way_.contains(arrival.path)) return;  // its reader tries again by itself
  // A camera may write an exposure in two formats.
  const bool twin = arrival.path != newest_ && arrival.path.stem() == newest_.stem();
  if (twin) return;
  for (const auto& [number, held] : held_) {
    if (held.path.stem() == arrival.path.stem()) return;
  }
  held_[next_photograph_] = arrival;
  match_.on_photograph(next_photograph_++, arrival.arrived_ns, arrival.written_ns);
}

/// photographs/shot-0007-NAME in the session's folder, with a number where that is taken.
fs::path PhotographPipeline::name_to_keep(const Arrival& arrival, const ShotKey& shot) {
  if (settings_.keep_folder.empty()) return {};
  const fs::path folder = settings_.keep_folder / "photographs";
  const std::string stem = fmt::format("shot-{:04}-{}", shot.shot_id, arrival.path.stem().string());
  fs::path path = folder / (stem + arrival.path.extension().string());
  std::error_code error;
  for (int i = 2; fs::exists(path, error) || names_given_.contains(path); ++i)
    path = folder / fmt::format("{}-{}{}", stem, i, arrival.path.extension().string());
  names_given_.insert(path);
  return path;
}

void PhotographPipeline::follow(const PhotographDecision& decision) {
  const auto entry = held_.extract(decision.photograph);
  if (entry.empty()) return;
  const Arrival& arrival = entry.mapped();
  if (!decision.shot)
    return notify(fmt::format("photograph {}: {}", arrival.path.filename().string(), decision.why));
  PhotographJob job;
  job.file = arrival.path;
  job.shot = *decision.shot;
  job.measure = decision.wanted;
  job.keep_as = name_to_keep(arrival, job.shot);
  job.may_link = arrival.renamed;
  job.flash_times_s = flash_times_s_[job.shot];
  newest_ = arrival.path;
  under_way_.insert(arrival.path);
  reader_.add(std::move(job));
}

void PhotographPipeline::finish(PhotographResult result) {
  const PhotographJob& job = result.job;
  const std::string what = fmt::format("photograph of shot {}", job.shot.shot_id);
  under_way_.erase(job.file);
  if (!result.reading) {
    match_.give_back(job.shot);
    newest_.clear();
    return notify(fmt::format("{}: {}", what, result.reading.error().message));
  }
  if (!result.not_kept.empty()) notify(fmt::format("{}: not kept: {}", what, result.not_kept));
  for (const std::string& remark : result.reading->remarks) notify(fmt::format("{}: {}", what, remark));
  if (!job.measure) return;
  strobe_msgs::frame_t frame = messages::frame_to_lcm(result.reading->frame);
  frame.boot_id = job.shot.boot_id;
  frame.shot_id = job.shot.shot_id;
  frame.host_id = settings_.host_id;
  if (frame.source.empty()) frame.source = "auto";
  const bool kept = !job.keep_as.empty() && result.not_kept.empty();
  frame.photograph =
      kept ? (fs::path("photographs") / job.keep_as.filename()).string() : job.file.filename().string();
  frames_.push_back(std::move(frame));
}

}  // namespace strobe::host
