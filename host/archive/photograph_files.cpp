#include "host/archive/photograph_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <system_error>

namespace strobe::host {

namespace fs = std::filesystem;

std::optional<int> shot_number_in(const fs::path& photograph) {
  constexpr std::string_view kBefore = "shot-";
  const std::string name = photograph.filename().string();
  if (!name.starts_with(kBefore)) return std::nullopt;
  int number = 0;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + kBefore.size(), end, number);
  if (read.ec != std::errc() || read.ptr == end || *read.ptr != '-' || number < 1) return std::nullopt;
  return number;
}

std::optional<fs::path> named_photograph(const fs::path& session, const std::string& name) {
  const fs::path given(name);
  if (given.parent_path() != "photographs" || given.filename().empty() || given.filename() == "..")
    return std::nullopt;
  std::error_code error;
  const fs::path path = session / given;
  return fs::is_regular_file(path, error) ? std::optional(path) : std::nullopt;
}

UnnamedPhotographs unnamed_photographs(const fs::path& session, const std::set<fs::path>& named,
                                       const std::vector<ShotKey>& without) {
  std::map<int, std::vector<fs::path>> files;
  std::error_code error;
  for (fs::directory_iterator entry(session / "photographs", error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path path = session / "photographs" / entry->path().filename();
    if (const auto number = shot_number_in(path); number && !named.contains(path))
      files[*number].push_back(path);
  }
  UnnamedPhotographs found;
  for (auto& [number, of_number] : files) {
    std::vector<ShotKey> shots;
    std::ranges::copy_if(without, std::back_inserter(shots),
                         [n = number](const ShotKey& key) { return key.shot_id == n; });
    if (shots.empty()) continue;
    std::ranges::sort(of_number);
    if (shots.size() == 1 && of_number.size() == 1) {
      found.of_shot[shots.front()] = of_number.front();
    } else {
      const std::string name = "photographs/" + of_number.front().filename().string();
      found.remarks.push_back(
          shots.size() > 1 ? fmt::format("{}: may show either of {} shots numbered {}, and is used for none",
                                         name, shots.size(), number)
                           : fmt::format("{} and {} more may show shot {}; none of them is used", name,
                                         of_number.size() - 1, number));
    }
  }
  return found;
}

}  // namespace strobe::host
