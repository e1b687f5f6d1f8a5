#include "sim/live/joined_program.hpp"

#include <stdlib.h>

#include <chrono>
#include <thread>

#include "sim/live/child_process.hpp"
#include "sim/live/temporary_folder.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

constexpr int kTries = 100;
constexpr std::chrono::milliseconds kTryEvery{100};

/// LD_PRELOAD is split at blanks and colons: a library whose path has some is reached by a link, as long as this program
/// lives.
fs::path preloadable(const fs::path& library) {
  if (library.string().find_first_of(" :") == std::string::npos) return library;
  static const TemporaryFolder folder;
  const fs::path link = folder.path() / library.filename();
  std::error_code error;
  fs::create_symlink(library, link, error);
  return fs::exists(link, error) ? link : library;
}

std::string preload_with(const fs::path& library) {
  const char* before = std::getenv("LD_PRELOAD");
  return before && *before ? library.string() + ":" + before : library.string();
}

}  // namespace

Result<int> start_joined(const std::vector<std::string>& command, const fs::path& chip_folder,
                         const std::function<void()>& join) {
  const auto library = preload_path();
  if (!library) return tl::unexpected(library.error());
  return start_child(
      command,
      {{"LD_PRELOAD", preload_with(preloadable(*library))}, {kChipDirVariable, chip_folder.string()}}, join);
}

Result<Chip> attach_to_rig(const fs::path& chip_folder) {
  auto chip = Chip::attach(chip_folder);
  for (int tries = 0; !chip && tries < kTries; ++tries) {
    std::this_thread::sleep_for(kTryEvery);
    chip = Chip::attach(chip_folder);
  }
  return chip;
}

}  // namespace strobe::sim
