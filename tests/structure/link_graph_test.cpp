// A folder is a library: one target compiles all of its files and no others', and no library links itself by
// way of others. As the build has it: CMakeLists.txt writes its targets into link_graph.txt.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/structure/folder_graph.hpp"
#include "tests/structure/source_tree.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe::structure;

struct LinkGraph {
  std::map<std::string, std::set<std::string>> sources;  ///< of each target, from the repository's root
  std::map<std::string, std::set<std::string>> links;    ///< of each target, only targets of the project
};

/// Lines "source TARGET PATH" and "link TARGET TARGET".
LinkGraph read_link_graph(std::istream& lines) {
  LinkGraph graph;
  for (std::string kind, target, value; lines >> kind >> target >> value;)
    (kind == "source" ? graph.sources : graph.links)[target].insert(value);
  return graph;
}

const LinkGraph& built() {
  static const LinkGraph graph = [] {
    std::ifstream file(std::filesystem::path(STROBE_BUILD_DIR) / "link_graph.txt");
    return read_link_graph(file);
  }();
  return graph;
}

/// The same program or library made with another libgpiod.
bool is_variant(const std::string& target) { return target.find("gpiod2") != std::string::npos; }

/// Folders of several libraries: firmware links neither JSON nor the reduction, and the library that is
/// loaded before a program's own has the chip's files once more, with nothing else.
const std::set<std::string> kDivided{"common/messages", "sim/gpiochip"};

/// Folders of the product and the targets that compile files of theirs.
std::map<std::string, std::set<std::string>> targets_by_folder(const LinkGraph& graph) {
  std::map<std::string, std::set<std::string>> found;
  for (const auto& [target, sources] : graph.sources)
    for (const std::string& source : sources)
      if (!is_variant(target)) found[folder_of(source)].insert(target);
  return found;
}

}  // namespace

TEST_GROUP(LinkGraph){};

TEST(LinkGraph, IsWrittenByTheBuild) { CHECK(built().sources.size() > 30); }

TEST(LinkGraph, IsReadAsWritten) {
  std::istringstream lines("source a common/a/x.cpp\nlink b a\nlink c b\n");
  const LinkGraph graph = read_link_graph(lines);
  CHECK(graph.sources.at("a") == std::set<std::string>{"common/a/x.cpp"});
  CHECK(graph.links.at("c") == std::set<std::string>{"b"});
}

TEST(LinkGraph, AFolderIsALibrary) {
  std::string wrong;
  for (const auto& [folder, targets] : targets_by_folder(built()))
    if (targets.size() > 1 && !kDivided.contains(folder))
      wrong += fmt::format("\n  {}/: {} and {}", folder, *targets.begin(), *targets.rbegin());
  for (const auto& [target, sources] : built().sources)
    if (folder_of(*sources.begin()) != folder_of(*sources.rbegin()) &&
        !kDivided.contains(folder_of(*sources.begin())))
      wrong += fmt::format("\n  {}: {} and {}", target, *sources.begin(), *sources.rbegin());
  CHECK_EQUAL("", wrong);
}

TEST(LinkGraph, EveryFileIsCompiled) {
  std::set<std::string> compiled;
  for (const auto& [target, sources] : built().sources) compiled.insert(sources.begin(), sources.end());
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    const bool is_source = file.path.ends_with(".cpp") && top_folder(file.path) != "tests";
    const bool other_libgpiod = file.path.find("gpio_chip_v") != std::string::npos;
    if (is_source && !other_libgpiod && !compiled.contains(file.path)) wrong += "\n  " + file.path;
  }
  CHECK_EQUAL("", wrong);
}

TEST(LinkGraph, EveryFoldersDutyStandsInTheREADMEAbove) {
  std::string wrong;
  for (const auto& [folder, targets] : targets_by_folder(built())) {
    std::filesystem::path above = std::filesystem::path(folder).parent_path();
    if (above.empty()) continue;
    while (!std::filesystem::exists(repository_root() / above / "README.md")) above = above.parent_path();
    const std::string name = std::filesystem::path(folder).lexically_relative(above).string();
    const std::string text = strobe::testing::read_text(repository_root() / above / "README.md");
    if (text.find("`" + name + "/`") == std::string::npos) wrong += "\n  " + folder;
  }
  CHECK_EQUAL("", wrong);
}

TEST(LinkGraph, HasNoCircle) {
  std::vector<FolderInclude> edges;
  for (const auto& [target, links] : built().links)
    for (const std::string& other : links) edges.push_back({target, other, target, 0, other});
  std::string wrong;
  for (const auto& circle : cycles(edges)) {
    wrong += "\n  circle:";
    for (const FolderInclude& edge : circle) wrong += fmt::format(" {} -> {}", edge.from, edge.to);
  }
  CHECK_EQUAL("", wrong);
}
