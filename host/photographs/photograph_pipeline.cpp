#include "host/photographs/photograph_pipeline.hpp"

#include <fmt/format.h>
#include <system_error>

#include "common/messages/lcm_conversions.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {

namespace fs = std::filesystem;

PhotographPipeline::PhotographPipeline(const DeviceClock& clock, std::unique_ptr<CameraFolder> folder,
                                       MeasurePhotograph measure, PhotographSettings settings)
    : folder_(std::move(folder)),
      settings_(std::move(settings)),
      matcher_(clock, settings_.timeout_s),
      reader_(std::move(measure), settings_.retry_timeout_s) {}

void PhotographPipeline::on_shot(const strobe_msgs::shot_t& shot) {
  matcher_.on_shot(shot);
  const ShotKey key{shot.boot_id, shot.shot_id};
  flash_times_s_.put(key, flash_times_s(shot));
  if (const auto* measured = measured_.find(key)) frames_.push_back(*measured);
}

void PhotographPipeline::on_frame(const strobe_msgs::frame_t& frame) {
  matcher_.on_measured({frame.boot_id, frame.shot_id});
}

std::vector<Arrival> PhotographPipeline::look(HostTime now) {
  if (!camera_) {
    for (std::string& text : folder_->take_notifications()) notify(std::move(text));
    return folder_->look(now);
  }
  camera_->step(now);
  std::vector<Arrival> arrivals;
  for (auto& photograph : camera_->take_photographs())
    arrivals.push_back({std::move(photograph.file), now, now, true, photograph.exposed, ""});
  for (tether::LostEvent& lost : camera_->take_lost()) {
    if (lost.exposed) {
      arrivals.push_back({fmt::format("frame {}", lost.number), now, now, false, lost.exposed, lost.why});
    } else {
      notify(fmt::format("a photograph is lost, the camera's frame {}: {}", lost.number, lost.why));
    }
  }
  for (std::string& text : camera_->take_notifications()) notify(std::move(text));
  return arrivals;
}

void PhotographPipeline::step(HostTime now) {
  for (const Arrival& arrival : look(now)) add(arrival);
  for (PhotographResult& result : reader_.take_results()) finish(std::move(result));
  for (const PhotographLight& light : reader_.take_light()) tell_light(light);
  for (const PhotographDecision& decision : matcher_.decide(now)) apply(decision);
}

void PhotographPipeline::end(HostTime now) {
  step(now);
  for (const PhotographDecision& decision : matcher_.end(now)) apply(decision);
}

void PhotographPipeline::add(const Arrival& arrival) {
  if (being_read_.contains(arrival.path)) return;  // its reader tries again by itself
  // A camera may write an exposure in two formats.
  const bool twin = arrival.path != newest_ && arrival.path.stem() == newest_.stem();
  if (twin) return;
  for (const auto& [number, other] : undecided_) {
    if (other.path.stem() == arrival.path.stem()) return;
  }
  undecided_[next_photograph_] = arrival;
  matcher_.on_photograph(next_photograph_++, arrival.arrived, arrival.written, arrival.exposed);
}

/// photographs/shot-0007-NAME in the session's folder, with a number where that is taken.
fs::path PhotographPipeline::name_to_keep(const fs::path& file, const ShotKey& shot) {
  if (settings_.keep_folder.empty()) return {};
  const fs::path folder = settings_.keep_folder / "photographs";
  const std::string stem = fmt::format("shot-{:04}-{}", shot.shot_id, file.stem().string());
  fs::path path = folder / (stem + file.extension().string());
  std::error_code error;
  for (int i = 2; fs::exists(path, error) || names_used_.contains(path); ++i)
    path = folder / fmt::format("{}-{}{}", stem, i, file.extension().string());
  names_used_.insert(path);
  return path;
}

void PhotographPipeline::apply(const PhotographDecision& decision) {
  const auto entry = undecided_.extract(decision.photograph);
  if (entry.empty()) return;
  const Arrival& arrival = entry.mapped();
  if (!arrival.lost.empty()) return tell_lost(arrival, decision);
  if (!decision.shot) {
    if (camera_) put_aside(arrival.path);
    return notify(fmt::format("photograph {}: {}", arrival.path.filename().string(), decision.why));
  }
  PhotographJob job;
  job.file = arrival.path;
  job.shot = *decision.shot;
  job.measure = decision.wanted;
  job.keep_as = name_to_keep(arrival.path, job.shot);
  job.may_link = arrival.renamed;
  if (const auto* times = flash_times_s_.find(job.shot)) job.flash_times_s = *times;
  newest_ = arrival.path;
  being_read_.insert(arrival.path);
  reader_.add(std::move(job));
}

void PhotographPipeline::tell_lost(const Arrival& arrival, const PhotographDecision& decision) {
  const std::string what = decision.shot ? fmt::format("photograph of shot {}", decision.shot->shot_id)
                                         : "a photograph of no shot";
  notify(fmt::format("{}: lost: {}", what, arrival.lost));
}

/// Where no later run takes it for a shot's.
void PhotographPipeline::put_aside(const fs::path& file) {
  std::error_code error;
  const fs::path folder = file.parent_path() / "unused";
  fs::create_directory(folder, error);
  fs::rename(file, folder / file.filename(), error);
}

std::vector<ShotKey> PhotographPipeline::measure_left(const LeftShots& shots, const DeviceClock& clock) {
  std::vector<ShotKey> found;
  for (const LeftPhotograph& left : match_left_photographs(shots, folder_->old_files(), settings_.keep_folder,
                                                           clock, settings_.timeout_s)) {
    PhotographJob job;
    job.file = left.file;
    job.shot = left.shot;
    if (!left.kept) job.keep_as = name_to_keep(left.file, left.shot);
    job.left = true;
    if (const auto* times = flash_times_s_.find(left.shot)) job.flash_times_s = *times;
    found.push_back(left.shot);
    ++left_;
    being_read_.insert(left.file);
    reader_.add(std::move(job));
  }
  return found;
}

/// What a frame calls its photograph.
std::string PhotographPipeline::name_in_session(const PhotographJob& job, bool kept) const {
  const fs::path folder = "photographs";
  if (!job.keep_as.empty() && kept) return (folder / job.keep_as.filename()).string();
  const bool own_copy =
      !settings_.keep_folder.empty() && job.file.parent_path() == settings_.keep_folder / folder;
  return own_copy ? (folder / job.file.filename()).string() : job.file.filename().string();
}

/// What stays as it is need not be said after every shot.
void PhotographPipeline::tell_light(const PhotographLight& light) {
  std::vector<light::Advice> news;
  for (const light::Advice& each : light.advice) {
    if (each.verdict == light::Verdict::ok) continue;
    if (told_of_light_.insert(fmt::format("{} {}", each.what, name(each.verdict))).second)
      news.push_back(each);
  }
  if (!news.empty())
    notify(fmt::format("photograph of shot {}: {}", light.shot.shot_id, light::in_short(news)));
}

void PhotographPipeline::finish(PhotographResult result) {
  const PhotographJob& job = result.job;
  left_ -= job.left ? 1 : 0;
  const std::string what = fmt::format("photograph of shot {}", job.shot.shot_id);
  being_read_.erase(job.file);
  if (!result.reading) {
    matcher_.give_back(job.shot);
    newest_.clear();
    return notify(fmt::format("{}: {}", what, result.reading.error().message));
  }
  if (!result.not_kept.empty()) not_kept_.push_back(fmt::format("{}: not kept: {}", what, result.not_kept));
  for (const std::string& remark : result.reading->remarks) notify(fmt::format("{}: {}", what, remark));
  const bool copied = !job.keep_as.empty() && result.not_kept.empty();
  std::error_code error;
  if (copied && camera_) fs::remove(job.file, error);
  kept_.push_back({job.shot, copied ? job.keep_as : job.file});
  if (!job.measure) return;
  strobe_msgs::frame_t frame = messages::frame_to_lcm(result.reading->frame);
  frame.boot_id = job.shot.boot_id;
  frame.shot_id = job.shot.shot_id;
  frame.host_id = settings_.host_id;
  if (frame.source.empty()) frame.source = "auto";
  frame.photograph = name_in_session(job, result.not_kept.empty());
  measured_.put(job.shot, frame);
  frames_.push_back(std::move(frame));
}

namespace {

tl::expected<PhotographReading, UnreadPhotograph> reading_of(const RigFile& rig, digitize::Effort effort,
                                                             const std::filesystem::path& file,
                                                             const std::vector<double>& flash_times_s,
                                                             bool with_light) {
  auto measured = measure_photograph(file, rig, {effort, flash_times_s, {}});
  if (!measured) return tl::unexpected(measured.error());
  PhotographReading reading;
  reading.frame = measured->found.frame;
  reading.remarks = measured->found.remarks;
  if (const auto& missing = measured->found.no_surface)
    reading.remarks.push_back("no surface line: " + missing->detail);
  if (with_light && !measured->found.outlines.empty()) {
    reading.advise = [whole = std::move(*measured)] {
      return light::advise(light::measure_light(whole.photograph, whole.settings.map, whole.found));
    };
  }
  return reading;
}

/// In the session's folder.
constexpr const char* kIncoming = "incoming";

Result<std::unique_ptr<tether::TetheredCamera>> start_camera(const CameraConnection& connection,
                                                             const fs::path& folder, double exposure_s,
                                                             HostTime now) {
  const auto program = tether::CameraDriver::find(std::string(name(connection.kind)));
  if (!program) return fail("camera.kind of the rig file: " + program.error().message);
  std::error_code error;
  fs::create_directories(folder, error);
  return tether::TetheredCamera::start(*program, open_request(connection, folder, exposure_s), now);
}

}  // namespace

tether::OpenRequest open_request(const CameraConnection& connection, const fs::path& folder,
                                 double exposure_s) {
  std::error_code error;
  tether::OpenRequest open;
  open.serial = connection.serial;
  open.address = connection.address;
  open.exposure_by_line = connection.exposure_by_line;
  open.exposure_s = exposure_s;
  open.set = connection.set;
  open.folder = fs::absolute(folder, error).string();
  open.delete_from_camera = connection.delete_from_camera;
  return open;
}

Result<std::unique_ptr<PhotographPipeline>> open_pipeline(const RigFile& rig,
                                                          const PhotographOptions& options,
                                                          const fs::path& keep_folder, std::int64_t host_id,
                                                          const DeviceClock& clock, const HostReading& now) {
  const bool speaks = options.folder.empty() && rig.camera.connection.kind != CameraKind::folder;
  if (speaks && keep_folder.empty()) return nullptr;
  const std::string from = speaks                   ? (keep_folder / kIncoming).string()
                           : options.folder.empty() ? rig.camera.folder.value_or("")
                                                    : options.folder;
  if (from.empty()) return nullptr;
  if (!rig.camera.px_per_m && !rig.analysis.px_per_m) {
    return fail(
        "photographs need a scale: camera.px_per_m (strobe calibrate) or analysis.px_per_m in the rig file");
  }
  std::unique_ptr<tether::TetheredCamera> camera;
  if (speaks) {
    auto started = start_camera(rig.camera.connection, from, options.exposure_s, now.mono);
    if (!started) return tl::unexpected(started.error());
    camera = std::move(*started);
  }
  auto folder = CameraFolder::open(from, now.mono);
  if (!folder)
    return fail((speaks                   ? "photographs: "
                 : options.folder.empty() ? "camera.folder of the rig file: "
                                          : "--photographs: ") +
                folder.error().message);
  const digitize::Effort effort = digitize::effort_from_name(options.effort).value();
  auto pipeline = std::make_unique<PhotographPipeline>(
      clock, std::move(*folder),
      [rig, effort, number = 0](const fs::path& file, const std::vector<double>& flash_times_s) mutable {
        // Light changes slowly, and measuring it takes some 50 ms of the next photograph's.
        constexpr int kLightOfEach = 8;
        return reading_of(rig, effort, file, flash_times_s, number++ % kLightOfEach == 0);
      },
      PhotographSettings{rig.analysis.photograph_timeout_s, host_id, keep_folder});
  pipeline->notify(speaks ? "photographs by " + std::string(name(rig.camera.connection.kind))
                          : "photographs from " + from);
  if (camera) pipeline->set_camera(std::move(camera));
  if (auto warning = calibration_warning(rig.camera, now.wall)) pipeline->notify(*warning);
  return pipeline;
}

}  // namespace strobe::host
