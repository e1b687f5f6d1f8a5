#include "tests/structure/source_tree.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

namespace strobe::structure {
namespace {

const std::set<std::string> kTextSuffixes{".cpp",  ".hpp", ".c",  ".h",       ".lcm",  ".txt", ".cmake",
                                          ".toml", ".md",  ".sh", ".service", ".json", ".in",  ""};
const std::set<std::string> kCppSuffixes{".cpp", ".hpp", ".c", ".h"};
const std::vector<std::string> kFolders{"common", "firmware", "host", "sim", "tests"};

SourceFile read(const std::filesystem::path& path, const std::filesystem::path& root) {
  SourceFile file;
  file.path = path.lexically_relative(root).generic_string();
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) file.lines.push_back(std::move(line));
  return file;
}

bool in_data_folder(const std::string& path) {
  return path.find("/data/") != std::string::npos || path.find("/corpus/") != std::string::npos;
}

}  // namespace

std::filesystem::path repository_root() { return std::filesystem::path(STROBE_SOURCE_DIR); }

bool starts_with(const std::string& text, const std::string& prefix) { return text.rfind(prefix, 0) == 0; }

std::string top_folder(const std::string& path) { return path.substr(0, path.find('/')); }

namespace {

std::vector<SourceFile> read_source_files() {
  const std::filesystem::path root = repository_root();
  std::vector<SourceFile> files;
  for (const std::string& folder : kFolders) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      if (!entry.is_regular_file() || kTextSuffixes.count(entry.path().extension().string()) == 0) continue;
      SourceFile file = read(entry.path(), root);
      const bool code = kCppSuffixes.count(entry.path().extension().string()) != 0;
      if (code || !in_data_folder(file.path)) files.push_back(std::move(file));
    }
  }
  for (const auto& entry : std::filesystem::directory_iterator(root))
    if (entry.is_regular_file() && kTextSuffixes.count(entry.path().extension().string()) != 0)
      files.push_back(read(entry.path(), root));
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

}  // namespace

const std::vector<SourceFile>& source_files() {
  static const std::vector<SourceFile> files = read_source_files();
  return files;
}

const std::vector<SourceFile>& cpp_files() {
  static const std::vector<SourceFile> files = [] {
    std::vector<SourceFile> all = source_files();
    std::erase_if(all, [](const SourceFile& file) {
      return kCppSuffixes.count(std::filesystem::path(file.path).extension().string()) == 0;
    });
    return all;
  }();
  return files;
}

std::vector<Include> includes_of(const SourceFile& file) {
  std::vector<Include> includes;
  for (std::size_t i = 0; i < file.lines.size(); ++i) {
    const std::string& line = file.lines[i];
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') continue;
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) continue;
    const std::size_t open = line.find_first_of("\"<", word);
    if (open == std::string::npos) continue;
    const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
    if (close == std::string::npos) continue;
    includes.push_back({line.substr(open + 1, close - open - 1), line[open] == '"', static_cast<int>(i) + 1});
  }
  return includes;
}

}  // namespace strobe::structure
