#include "common/config/files.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>

namespace strobe::config {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const {
    if (file != stdin) std::fclose(file);
  }
};

}  // namespace

Result<std::string> read_file(const std::string& path) {
  constexpr std::size_t kMaxBytes = 16u << 20;
  const std::unique_ptr<std::FILE, FileCloser> file(path == "-" ? stdin : std::fopen(path.c_str(), "rb"));
  if (!file) return fail(path + ": " + std::strerror(errno));
  std::string text;
  std::array<char, 65536> block{};
  while (const std::size_t n = std::fread(block.data(), 1, block.size(), file.get())) {
    text.append(block.data(), n);
    if (text.size() > kMaxBytes) return fail(path + ": larger than 16 MB");
  }
  if (std::ferror(file.get())) return fail(path + ": " + std::strerror(errno));
  return text;
}

Result<void> write_file(const std::filesystem::path& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return fail(path.string() + ": cannot be written");
  return {};
}

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

}  // namespace strobe::config
