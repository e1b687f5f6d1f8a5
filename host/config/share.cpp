#include "host/config/share.hpp"

#include <cstdlib>
#include <system_error>

namespace strobe::host {

Result<std::filesystem::path> share_folder() {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path folder;
  if (const char* given = std::getenv("STROBE_SHARE"); given && *given) {
    folder = given;
  } else {
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    if (error) return fail("cannot find the program's own folder: " + error.message());
    folder = self.parent_path().parent_path() / "share" / "strobe";
  }
  if (!fs::is_directory(folder, error)) {
    return fail(folder.string() + ": no such folder (STROBE_SHARE names the one with scenes and tables)");
  }
  return folder;
}

}  // namespace strobe::host
