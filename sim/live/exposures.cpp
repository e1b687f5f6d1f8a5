#include "sim/live/exposures.hpp"

#include <cerrno>
#include <cstring>

#include "sim/photograph/lit_balls.hpp"
#include "sim/rig/truth.hpp"

namespace strobe::sim {

void ExposureStore::add(Exposure exposure) {
  auto kept = std::make_shared<const Exposure>(std::move(exposure));
  const std::lock_guard lock(mutex_);
  exposures_.push_back(std::move(kept));
}

void ExposureStore::set_exposing(std::optional<MonoTime> since) {
  const std::lock_guard lock(mutex_);
  exposing_since_ = since;
}

ExposureStore::Found ExposureStore::begun_within(MonoTime earliest, MonoTime latest) const {
  const std::lock_guard lock(mutex_);
  for (const auto& exposure : exposures_) {
    if (exposure->line_on >= earliest && exposure->line_on <= latest) return {exposure, false};
  }
  const bool under_way = exposing_since_ && *exposing_since_ >= earliest && *exposing_since_ <= latest;
  return {nullptr, under_way};
}

std::vector<std::shared_ptr<const Exposure>> ExposureStore::all() const {
  const std::lock_guard lock(mutex_);
  return exposures_;
}

Result<std::unique_ptr<TruthFile>> TruthFile::create(const std::filesystem::path& path, const Scene& scene) {
  std::unique_ptr<TruthFile> truth(new TruthFile(scene));
  if (!path.empty()) {
    truth->path_ = path;
    truth->file_.open(path);
    if (!truth->file_) return fail(path.string() + ": cannot be written: " + std::strerror(errno));
  }
  return truth;
}

std::string TruthFile::line(const Exposure& exposure, int shot_id) const {
  if (!photograph_seed_) return truth_line(scene_, exposure, shot_id);
  const Appearance appearance = draw_appearance(scene_, *photograph_seed_, exposure.shot);
  const PhotographTruth truth =
      photograph_truth(scene_, exposure, appearance, lit_balls(scene_, exposure, appearance));
  return photograph_line(scene_, exposure, shot_id, appearance, truth, "");
}

void TruthFile::write(const Exposure& exposure, int shot_id) {
  const std::lock_guard lock(mutex_);
  if (!file_.is_open()) return;
  if (exposure.shot != 0 && !written_.insert(exposure.shot).second) return;
  file_ << line(exposure, shot_id) << std::endl;
}

Result<void> TruthFile::close() {
  const std::lock_guard lock(mutex_);
  if (!file_.is_open()) return {};
  file_.close();
  if (!file_) return fail(path_.string() + ": not all could be written");
  return {};
}

}  // namespace strobe::sim
