// The kernel's files under /proc and /sys, as text, below a root that tests replace. Set-up only, not
// real-time.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace strobe::firmware {

class SystemFiles {
 public:
  /// root: "/" on a real system; paths below are given without a leading slash.
  explicit SystemFiles(std::filesystem::path root = "/") : root_(std::move(root)) {}

  /// The content without white space at its end. Returns nullopt if the file is absent or not readable.
  std::optional<std::string> read(const std::string& path) const;
  bool write(const std::string& path, const std::string& text) const;  ///< false if refused
  /// Names in a folder, sorted: numbers by value; empty if there is no such folder.
  std::vector<std::string> list(const std::string& path) const;
  bool is_folder(const std::string& path) const;
  /// Where it leads through all links, below the root; nullopt if it is absent or leads elsewhere.
  std::optional<std::string> resolved(const std::string& path) const;
  /// Whether its mode lets the owner write, whoever calls.
  bool owner_may_write(const std::string& path) const;

 private:
  std::filesystem::path root_;
};

/// Whether it is digits only, as the kernel numbers chips and interrupts.
inline bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// "0-2,5" as {0, 1, 2, 5}, as the kernel writes lists of CPUs; malformed parts are skipped.
std::set<int> parse_cpu_list(const std::string& list);
/// Where a thread may run: on that CPU, or for -1 on all that are online.
std::set<int> allowed_cpus(int cpu, const SystemFiles& files);

/// The reverse: {0, 1, 2, 5} as "0-2,5".
std::string format_cpu_list(const std::set<int>& cpus);
/// "1,00000003" as {0, 1, 32}, as the kernel writes masks: hexadecimal, 32 CPUs a group; empty if malformed.
std::set<int> parse_cpu_mask(const std::string& mask);
/// The reverse.
std::string format_cpu_mask(const std::set<int>& cpus);

}  // namespace strobe::firmware
