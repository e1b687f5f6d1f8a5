#include "tests/costs/counts.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <regex>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::costs {
namespace {

using namespace std::chrono_literals;

/// The C library and OpenCV choose code by the processor; this keeps to what every x86-64 has, so that counts agree.
const std::map<std::string, std::string> kPlainProcessor{
    {"GLIBC_TUNABLES",
     "glibc.cpu.hwcaps=-AVX2_Usable,-AVX2,-FMA_Usable,-FMA,-FMA4_Usable,-FMA4,-AVX_Usable,-AVX"},
    {"OPENCV_CPU_DISABLE", "SSE4.1,SSE4.2,AVX,FP16,AVX2,FMA3,AVX512F,AVX512_SKX"}};

std::string machine() {
  utsname name{};
  uname(&name);
  return name.machine;
}

}  // namespace

std::optional<std::int64_t> total_of(const std::string& callgrind_output) {
  static const std::regex totals("(?:^|\n)totals: ([0-9]+)");
  std::smatch match;
  if (!std::regex_search(callgrind_output, match, totals)) return std::nullopt;
  return std::stoll(match[1]);
}

std::string build() {
  return fmt::format("{}, {} {}, {}", machine(), STROBE_COMPILER, STROBE_COMPILER_MAJOR, STROBE_OPTIMIZATION);
}

Result<Counts> count(const std::vector<std::string>& names) {
  const testing::TemporaryFolder folder;
  const std::string output = folder / "callgrind";
  const auto finished = testing::run_process(
      {{"valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=strobe_costs_counted",
        "--dump-after=strobe_costs_counted", "--callgrind-out-file=" + output,
        std::filesystem::read_symlink("/proc/self/exe"), "run"},
       kPlainProcessor,
       {},
       {}},
      600s);
  if (finished.status != testing::ExitStatus{0, 0})
    return fail("callgrind did not run to its end:\n" + finished.err);
  Counts counts;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto total = total_of(testing::read_text(fmt::format("{}.{}", output, i + 1)));
    if (!total || *total == 0) return fail("callgrind counted nothing of " + names[i]);
    counts[names[i]] = *total;
  }
  return counts;
}

std::vector<std::string> complaints(const Counts& recorded, const Counts& counted) {
  std::vector<std::string> lines;
  for (const auto& [name, count] : counted) {
    const auto record = recorded.find(name);
    if (record == recorded.end()) {
      lines.push_back(fmt::format("{} is not recorded: {} instructions", name, count));
    } else if (static_cast<double>(count) > kMaxGrowth * static_cast<double>(record->second)) {
      lines.push_back(fmt::format(
          "{} costs {} instructions, {:+.1f} % on the record's {}", name, count,
          100.0 * (static_cast<double>(count) / static_cast<double>(record->second) - 1.0), record->second));
    }
  }
  for (const auto& [name, count] : recorded)
    if (counted.count(name) == 0) lines.push_back(name + " is recorded but no longer counted");
  return lines;
}

}  // namespace strobe::costs
