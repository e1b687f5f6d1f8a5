#include "host/commands/frontier/frontier_files.hpp"

#include <filesystem>
#include <system_error>

#include "common/config/files.hpp"
#include "common/units/tolerance.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

Result<FrontierFiles> read_frontier(const std::string& file) {
  namespace fs = std::filesystem;
  fs::path path = file;
  if (file.empty()) {
    const auto share = config::share_folder();
    if (!share) return tl::unexpected(share.error());
    path = *share / "frontier" / "frontier.csv";
  }
  FrontierFiles files;
  const auto text = config::read_file(path.string());
  if (!text) return tl::unexpected(text.error());
  auto rows = frontier::parse_frontier(*text, path.string());
  if (!rows) return tl::unexpected(rows.error());
  files.rows = std::move(*rows);

  const fs::path beside = path.parent_path() / "ranges.csv";
  std::error_code error;
  if (!fs::exists(beside, error)) return files;
  const auto ranges_text = config::read_file(beside.string());
  if (!ranges_text) return tl::unexpected(ranges_text.error());
  auto ranges = frontier::parse_ranges(*ranges_text, beside.string());
  if (!ranges) return tl::unexpected(ranges.error());
  files.ranges = std::move(*ranges);
  return files;
}

Result<frontier::Requirement> parse_requirement(const std::string& tolerance,
                                                std::optional<double> deadline_us) {
  frontier::Requirement requirement{.tolerance = std::nullopt, .deadline_us = deadline_us};
  if (deadline_us && !(*deadline_us > 0.0)) return fail("--deadline-us must be above 0");
  if (tolerance.empty()) return requirement;
  const auto value = parse_tolerance(tolerance);
  if (!value) return fail("--tolerance: " + value.error().message);
  requirement.tolerance = *value;
  return requirement;
}

}  // namespace strobe::host
