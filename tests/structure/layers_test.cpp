// Folders are layers: no folder includes another that includes it, by whatever way, neither among all folders nor, in the
// product, among those of one level.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/structure/folder_graph.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::structure;

/// The first `depth` folders of a path: of host/digitize/path at a depth of 2 host/digitize.
std::string at_depth(const std::string& folder, int depth) {
  std::size_t end = 0;
  for (int level = 0; level < depth && end != std::string::npos; ++level)
    end = folder.find('/', level == 0 ? 0 : end + 1);
  return folder.substr(0, end);
}

/// The product's includes that lead from one of the folders of this level to another.
std::vector<FolderInclude> includes_at_depth(const std::vector<SourceFile>& files, int depth) {
  std::vector<FolderInclude> found = includes_between_folders(files);
  std::erase_if(found, [](const FolderInclude& include) { return top_folder(include.from) == "tests"; });
  for (FolderInclude& include : found) {
    include.from = at_depth(include.from, depth);
    include.to = at_depth(include.to, depth);
  }
  std::erase_if(found, [](const FolderInclude& include) { return include.from == include.to; });
  return found;
}

std::string in_words(const std::vector<std::vector<FolderInclude>>& circles) {
  std::string words;
  for (const auto& circle : circles) {
    words += "\ncircle:";
    for (const FolderInclude& include : circle)
      words += fmt::format("\n  {}:{}: {}", include.file, include.line, include.target);
  }
  return words;
}

}  // namespace

TEST_GROUP(Layers){};

TEST(Layers, AFolderOfALevelStandsForThoseBelowIt) {
  CHECK_EQUAL("host/digitize", at_depth("host/digitize/path", 2));
  CHECK_EQUAL("host", at_depth("host", 2));
  const std::vector<SourceFile> files{{"host/a/x/f.cpp", {"#include \"host/b/g.hpp\""}},
                                      {"host/b/g.hpp", {"#include \"host/a/y/h.hpp\""}}};
  CHECK(cycles(includes_between_folders(files)).empty());
  CHECK_EQUAL(1U, cycles(includes_at_depth(files, 2)).size());
}

TEST(Layers, FormNoCircle) { CHECK_EQUAL("", in_words(cycles(includes_between_folders(cpp_files())))); }

TEST(Layers, FormNoCircleAtAnyLevelOfTheProduct) {
  for (const int depth : {1, 2, 3}) CHECK_EQUAL("", in_words(cycles(includes_at_depth(cpp_files(), depth))));
}
