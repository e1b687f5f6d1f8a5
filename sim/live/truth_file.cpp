#include "sim/live/truth_file.hpp"

#include <cerrno>
#include <cstring>

#include "sim/photograph/photograph_truth.hpp"
#include "sim/rig/truth.hpp"

namespace strobe::sim {

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
