// Dependencies point one way: common <- firmware, host, sim; the cores stay free of the operating system.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/structure/source_tree.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::structure;

/// What each folder's files may include with quotes.
const std::map<std::string, std::set<std::string>> kMayInclude{
    {"common", {"common"}},
    {"firmware", {"firmware", "common"}},
    {"host", {"host", "common"}},
    {"sim", {"sim", "common"}},
    {"tests", {"tests", "sim", "host", "firmware", "common"}},
};

/// Standard headers that let neither time, threads nor the outside world into deterministic code.
const std::set<std::string> kPureStandardHeaders{"algorithm",
                                                 "any",
                                                 "array",
                                                 "atomic",
                                                 "bit",
                                                 "bitset",
                                                 "cassert",
                                                 "cctype",
                                                 "cerrno",
                                                 "cfloat",
                                                 "charconv",
                                                 "cinttypes",
                                                 "climits",
                                                 "cmath",
                                                 "compare",
                                                 "complex",
                                                 "concepts",
                                                 "cstddef",
                                                 "cstdint",
                                                 "cstring",
                                                 "deque",
                                                 "exception",
                                                 "format",
                                                 "forward_list",
                                                 "functional",
                                                 "initializer_list",
                                                 "iterator",
                                                 "limits",
                                                 "list",
                                                 "map",
                                                 "memory",
                                                 "numbers",
                                                 "numeric",
                                                 "optional",
                                                 "queue",
                                                 "ranges",
                                                 "ratio",
                                                 "set",
                                                 "span",
                                                 "sstream",
                                                 "stack",
                                                 "stdexcept",
                                                 "string",
                                                 "string_view",
                                                 "tuple",
                                                 "type_traits",
                                                 "unordered_map",
                                                 "unordered_set",
                                                 "utility",
                                                 "variant",
                                                 "vector",
                                                 "version",
                                                 "source_location",
                                                 "cstdlib",
                                                 "locale",
                                                 "iomanip",
                                                 "ostream",
                                                 "istream",
                                                 "iosfwd"};

std::string complaint(const SourceFile& file, const Include& include, const std::string& why) {
  return fmt::format("\n  {}:{}: {} {}", file.path, include.line, include.target, why);
}

std::string directory_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

bool is_pure(const Include& include) {
  if (include.quoted) return true;
  return kPureStandardHeaders.count(include.target) != 0 || starts_with(include.target, "tl/") ||
         starts_with(include.target, "Eigen/") || starts_with(include.target, "boost/math/") ||
         starts_with(include.target, "boost/numeric/odeint/") ||
         (starts_with(include.target, "boost/random/") && include.target != "boost/random/random_device.hpp");
}

}  // namespace

TEST_GROUP(IncludeGraph){};

TEST(IncludeGraph, QuotedIncludesAreWrittenFromTheRootAndExist) {
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    for (const Include& include : includes_of(file))
      if (include.quoted && !std::filesystem::exists(repository_root() / include.target))
        wrong += complaint(file, include, "is not a file of the repository");
  }
  CHECK_EQUAL("", wrong);
}

TEST(IncludeGraph, FoldersIncludeOnlyWhatTheyMayDependOn) {
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    const auto allowed = kMayInclude.find(top_folder(file.path));
    if (allowed == kMayInclude.end()) continue;
    for (const Include& include : includes_of(file))
      if (include.quoted && allowed->second.count(top_folder(include.target)) == 0)
        wrong += complaint(file, include, "points the wrong way");
  }
  CHECK_EQUAL("", wrong);
}

TEST(IncludeGraph, TheFirmwaresCoreSeesOnlyPortsAndCommon) {
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    if (!starts_with(file.path, "firmware/core/") && !starts_with(file.path, "firmware/ports/")) continue;
    for (const Include& include : includes_of(file)) {
      const bool inside = starts_with(include.target, "firmware/core/") ||
                          starts_with(include.target, "firmware/ports/") ||
                          starts_with(include.target, "common/");
      if (include.quoted && !inside)
        wrong += complaint(file, include, "is outside the core's ports and common");
      if (!include.quoted && !is_pure(include))
        wrong += complaint(file, include, "lets the system into the core");
    }
  }
  CHECK_EQUAL("", wrong);
}

TEST(IncludeGraph, PortsAreHeadersOnly) {
  for (const SourceFile& file : cpp_files()) {
    if (!starts_with(file.path, "firmware/ports/")) continue;
    CHECK_TEXT(std::filesystem::path(file.path).extension() == ".hpp", file.path.c_str());
  }
}

TEST(IncludeGraph, TheAnalysisCoreSeesNoSystemThreadsOrClocks) {
  const std::vector<std::string> pure{"common/units/",   "common/ball/",    "common/impact/",
                                      "common/flight/",  "common/contact/", "common/reduction/",
                                      "common/geometry/"};
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    bool core = false;
    for (const std::string& folder : pure) core = core || starts_with(file.path, folder);
    if (!core) continue;
    for (const Include& include : includes_of(file)) {
      const bool time_type = file.path == "common/units/time.hpp" && include.target == "chrono";
      if (!is_pure(include) && !time_type) wrong += complaint(file, include, "is not for deterministic code");
    }
    for (const std::string& line : file.lines) {
      for (const char* clock : {"steady_clock", "system_clock", "high_resolution_clock"})
        if (line.find(clock) != std::string::npos) wrong += fmt::format("\n  {}: {}", file.path, clock);
    }
  }
  CHECK_EQUAL("", wrong);
}

TEST(IncludeGraph, CommonHasNoLinuxOrPosixHeaders) {
  // Firmware and host must judge a secret's rights alike, and meet strangers' bytes alike; host and simulator
  // must say alike that a file is on the disk.
  const std::set<std::string> met_alike{"common/authentication/key_file.cpp", "common/config/files.cpp",
                                        "common/wire/channel_socket.cpp", "common/wire/link_changes.cpp"};
  const std::set<std::string> system{"unistd.h",    "fcntl.h", "poll.h",  "pthread.h", "sched.h",
                                     "signal.h",    "csignal", "time.h",  "dirent.h",  "dlfcn.h",
                                     "semaphore.h", "spawn.h", "netdb.h", "ctime"};
  std::string wrong;
  for (const SourceFile& file : cpp_files()) {
    const bool excepted = met_alike.count(file.path) != 0;
    if (top_folder(file.path) != "common" || excepted) continue;
    for (const Include& include : includes_of(file)) {
      if (include.quoted) continue;
      const std::string folder = directory_of(include.target);
      if (system.count(include.target) != 0 || folder == "sys" || folder == "linux" || folder == "net" ||
          folder == "netinet" || folder == "arpa")
        wrong += complaint(file, include, "is the operating system's");
    }
  }
  CHECK_EQUAL("", wrong);
}

TEST(IncludeGraph, NoModuleOfOpenCVThatLoadsAHundredLibrariesIsUsed) {
  const std::set<std::string> heavy{"opencv2/imgcodecs.hpp", "opencv2/highgui.hpp", "opencv2/videoio.hpp",
                                    "opencv2/opencv.hpp"};
  std::string wrong;
  for (const SourceFile& file : cpp_files())
    for (const Include& include : includes_of(file))
      if (heavy.count(include.target) != 0)
        wrong += complaint(file, include,
                           "makes each program start in 80 ms; common/image reads and writes files");
  CHECK_EQUAL("", wrong);
}
