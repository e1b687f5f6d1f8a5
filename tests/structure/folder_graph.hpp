// The graph of the project's folders: an edge for each include from one folder into another. Values only.
#pragma once

#include <string>
#include <vector>

#include "tests/structure/source_tree.hpp"

namespace strobe::structure {

/// An include of one folder's file in another folder's.
struct FolderInclude {
  std::string from;    ///< folder of the file that includes
  std::string to;      ///< folder of the included file
  std::string file;    ///< the file that includes
  int line = 0;        ///< 1-based
  std::string target;  ///< the included file
};

/// Folder of a path from the repository's root; empty for a file at the root.
std::string folder_of(const std::string& path);

/// Quoted includes of these files that lead into another folder, in the order of the files.
std::vector<FolderInclude> includes_between_folders(const std::vector<SourceFile>& files);

/// The includes that make cycles, one group for each strongly connected component with more than one folder
/// (R. Tarjan: Depth-first search and linear graph algorithms, SIAM J. Comput. 1, 1972).
std::vector<std::vector<FolderInclude>> cycles(const std::vector<FolderInclude>& includes);

}  // namespace strobe::structure
