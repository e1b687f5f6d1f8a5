#include "tests/structure/folder_graph.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace strobe::structure {

namespace {

using Graph = std::map<std::string, std::set<std::string>>;

/// Numbers each folder's component.
class Tarjan {
 public:
  explicit Tarjan(const Graph& graph) : graph_(graph) {
    for (const auto& [folder, targets] : graph_)
      if (!nodes_.contains(folder)) visit(folder);
  }

  int component(const std::string& folder) const { return nodes_.at(folder).component; }

 private:
  struct Node {
    int index = 0, low = 0;
    int component = -1;  // not yet known: on the stack
  };

  int visit(const std::string& folder) {
    const int index = static_cast<int>(nodes_.size());
    Node& node = nodes_[folder] = {index, index, -1};
    stack_.push_back(folder);
    for (const std::string& target : graph_.at(folder)) {
      const auto seen = nodes_.find(target);
      if (seen == nodes_.end())
        node.low = std::min(node.low, visit(target));
      else if (seen->second.component < 0)
        node.low = std::min(node.low, seen->second.index);
    }
    if (node.low == node.index) close_component(folder);
    return node.low;
  }

  void close_component(const std::string& root) {
    std::string folder;
    do {
      folder = stack_.back();
      stack_.pop_back();
      nodes_.at(folder).component = components_;
    } while (folder != root);
    ++components_;
  }

  const Graph& graph_;
  std::map<std::string, Node> nodes_;  // a map, so that references stay valid
  std::vector<std::string> stack_;
  int components_ = 0;
};

}  // namespace

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

std::vector<FolderInclude> includes_between_folders(const std::vector<SourceFile>& files) {
  std::vector<FolderInclude> found;
  for (const SourceFile& file : files) {
    const std::string from = folder_of(file.path);
    for (const Include& include : includes_of(file)) {
      const std::string to = folder_of(include.target);
      if (include.quoted && to != from) found.push_back({from, to, file.path, include.line, include.target});
    }
  }
  return found;
}

std::vector<std::vector<FolderInclude>> cycles(const std::vector<FolderInclude>& includes) {
  Graph graph;
  for (const FolderInclude& include : includes) {
    graph[include.from].insert(include.to);
    graph[include.to];
  }
  const Tarjan components(graph);
  std::map<int, std::vector<FolderInclude>> inside;
  for (const FolderInclude& include : includes) {
    const int component = components.component(include.from);
    if (component == components.component(include.to)) inside[component].push_back(include);
  }
  std::vector<std::vector<FolderInclude>> result;
  for (auto& [component, members] : inside) result.push_back(std::move(members));
  return result;
}

}  // namespace strobe::structure
