// The project's own text files as the structure tests see them. Reads the disk, once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace strobe::structure {

struct SourceFile {
  std::string path;                ///< from the repository's root, with slashes
  std::vector<std::string> lines;  ///< without line ends
};

/// One #include directive.
struct Include {
  std::string target;  ///< what stands between the quotes or brackets
  bool quoted = false;
  int line = 0;  ///< 1-based
};

std::filesystem::path repository_root();

/// Every text file of the project's folders (not build, not data), sorted by path.
const std::vector<SourceFile>& source_files();

/// C and C++ sources and headers among them.
const std::vector<SourceFile>& cpp_files();

std::vector<Include> includes_of(const SourceFile& file);

/// The top-level folder of a path, or the path itself where there is none.
std::string top_folder(const std::string& path);

bool starts_with(const std::string& text, const std::string& prefix);

}  // namespace strobe::structure
