// What else the machine does while the loop is measured: processes of ordinary priority that end with this
// object.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace strobe::benchmarks::timing {

inline const std::vector<std::string> kLoads{"idle", "cpu", "memory"};

class Load {
 public:
  /// "idle": nothing; "cpu": one busy process a core; "memory": one process a core that copies 64 MiB to and
  /// fro, and one that writes 64 MiB to a file in the folder and syncs it, repeatedly.
  Load(const std::string& kind, const std::filesystem::path& folder);
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;
  ~Load();

 private:
  template <typename Work>
  void start(Work work);
  std::vector<pid_t> processes_;
  std::filesystem::path file_;
};

}  // namespace strobe::benchmarks::timing
