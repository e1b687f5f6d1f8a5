#include "sim/live/truth_file.hpp"

#include "sim/rig/truth.hpp"

namespace strobe::sim {

Result<std::unique_ptr<TruthFile>> TruthFile::create(const std::filesystem::path& path, const Scene& scene) {
  std::unique_ptr<TruthFile> truth(new TruthFile(scene));
  if (!path.empty()) {
    truth->file_.open(path);
    if (!truth->file_) return fail(path.string() + ": cannot be written");
  }
  return truth;
}

void TruthFile::write(const Exposure& exposure, int shot_id) {
  const std::lock_guard lock(mutex_);
  if (!file_.is_open()) return;
  if (exposure.shot != 0 && !written_.insert(exposure.shot).second) return;
  file_ << truth_line(scene_, exposure, shot_id) << std::endl;
}

}  // namespace strobe::sim
