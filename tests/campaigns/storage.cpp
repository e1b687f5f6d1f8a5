#include "tests/campaigns/storage.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::storage {
namespace {

namespace fs = std::filesystem;
using campaigns::Verdict;
using testing::DiskFault;

constexpr std::array kErrors{ENOSPC, EROFS, EDQUOT, EIO, ESTALE, EFBIG, EMFILE};

/// Where and when: which calls there are, how many of them are made, and how often of the rest they are drawn.
struct Place {
  const char* file;
  const char* call;
  int calls;
  int weight = 1;
};
// A series of three shots.
const std::vector<Place> kSessionPlaces{{"host-20260131T10", "write", 120, 3},
                                        {"host-20260131T10", "fsync", 4},
                                        {"host-20260131T10", "close", 1},
                                        {"host-20260131T10", "open", 1},
                                        {"results.csv", "write", 3, 2},
                                        {"results.csv", "fsync", 4},
                                        {"results.csv", "close", 1},
                                        {"results.csv", "open", 1},
                                        {"session.lock", "flock", 1},
                                        {"flashes.csv", "write", 3, 2},
                                        {"flashes.csv", "fsync", 4},
                                        {"flashes.csv", "close", 1},
                                        {"flashes.csv", "open", 1},
                                        {"", "fsync", 14},
                                        {"", "memory", 20'000, 2},
                                        {"", "remove folder", 14},
                                        {"", "rename folder", 14},
                                        {"results.csv", "remove file", 14},
                                        {"host-20260131T100000Z.lcmlog", "remove file", 14},
                                        {"", "write", 130, 2},
                                        {"", "open", 4}};
const std::vector<Place> kFilePlaces{
    {"", "write", 3}, {"", "fsync", 2}, {"", "close", 2}, {"", "rename", 1}, {"", "open", 1}};
const std::vector<Place> kKeyPlaces{{"", "write", 1}, {"", "fsync", 2}, {"", "close", 2}, {"", "link", 1}};

constexpr std::array kEndings{"not reached", "harmless", "refused", "told, stored after all",
                              "told, unstored named"};

const std::string kOld(3'000'000, 'o');
const std::string kNew(2'500'000, 'n');

/// Of a file written in one go: told is what the writer said, empty if it is stored.
Verdict judge_file(const fs::path& path, const std::string& told, const std::string& before,
                   const std::string& wanted) {
  Verdict verdict;
  const std::string now = testing::read_text(path);
  if (told.empty() && now != wanted) verdict.violate("told as stored, and is not");
  if (now != before && now != wanted) verdict.violate("neither the old file nor the new one");
  if (!told.empty() && told.find(path.filename().string()) == told.npos)
    verdict.violate("the file is not named");
  for (const auto& entry : fs::directory_iterator(path.parent_path()))
    if (entry.path().extension() == ".new") verdict.violate("a draft is left over");
  verdict.words = told;
  const bool reached = testing::disk_faults_injected() > 0;
  verdict.count(!reached        ? "not reached"
                : told.empty()  ? "harmless"
                : now == wanted ? "told, stored after all"
                                : "refused");
  if (!reached && !told.empty()) verdict.violate("told a failure that was none");
  return verdict;
}

/// What the function returns, with the disk at fault meanwhile.
template <typename Function>
auto with_fault(const DiskFault& fault, const Function& function) {
  testing::set_disk_fault(fault);
  auto result = function();
  testing::clear_disk_fault();
  return result;
}

Verdict run_replaced(const fs::path& path, const DiskFault& fault) {
  testing::write_text(path, kOld);
  const auto written = with_fault(fault, [&] { return config::write_file(path, kNew); });
  return judge_file(path, testing::error_of(written), kOld, kNew);
}

Verdict run_copied(const fs::path& path, const DiskFault& fault) {
  const fs::path from = path.parent_path() / "exposure.tif";
  testing::write_text(from, kNew);
  const auto copied = with_fault(fault, [&] { return config::copy_file(from, path); });
  return judge_file(path, testing::error_of(copied), "", kNew);
}

Verdict run_key(const fs::path& path, const DiskFault& fault) {
  const auto made = with_fault(fault, [&] { return authentication::make_key_file(path); });
  const bool readable = authentication::read_key_file(path).has_value();
  const std::string wanted = made ? made->key.text() + "\n" : readable ? testing::read_text(path) : "a key";
  Verdict verdict = judge_file(path, testing::error_of(made), "", wanted);
  if (made && !readable) verdict.violate("the key cannot be read");
  return verdict;
}

Verdict run_target(const std::string& target, const fs::path& folder, const DiskFault& fault) {
  if (target == "replaced file") return run_replaced(folder / "camera.toml", fault);
  if (target == "copied file") return run_copied(folder / "shot-0001-exposure.tif", fault);
  if (target == "key") return run_key(folder / "lab.key", fault);
  fs::create_directory(folder / "session");
  return run_session(folder / "session", fault);
}

/// File, call and error. Memory that is refused and files that are taken away have no errno.
std::string row_of(const Trial& trial) {
  const DiskFault& fault = trial.fault;
  const std::string of_session = fault.file.empty() ? "any of a session" : fault.file;
  const bool is_error = fault.call != "memory" && fault.call.find(' ') == fault.call.npos;
  return fmt::format("{}, {}{}", trial.target == "session" ? of_session : trial.target, fault.call,
                     is_error ? fmt::format(" {}", strerrorname_np(fault.error)) : "");
}

const Place& place_of(campaigns::Draws& draws, const std::vector<Place>& places) {
  std::vector<int> weights;
  for (const Place& place : places) weights.push_back(place.weight);
  return places[static_cast<std::size_t>(draws.weighted(weights))];
}

}  // namespace

Trial drawn(campaigns::Draws draws) {
  Trial trial;
  const int kind = draws.between(0, 9);
  trial.target = kind < 7 ? "session" : kind == 7 ? "replaced file" : kind == 8 ? "copied file" : "key";
  const Place& place = place_of(draws, kind < 7 ? kSessionPlaces : kind < 9 ? kFilePlaces : kKeyPlaces);
  DiskFault& fault = trial.fault;
  fault.file = place.file;
  fault.call = place.call;
  fault.nth = draws.between(1, place.calls);
  fault.times = draws.choice(std::array{1, 1, 2, 5, 20, 1'000'000});
  fault.error = draws.choice(kErrors);
  if (fault.call == "write" && draws.between(0, 3) == 0) fault.error = EINTR;
  if (fault.error == EINTR && fault.times > 20) fault.times = 20;  // for ever, no program would come back
  if (fault.call == "write" && draws.chance(0.5)) fault.short_bytes = draws.between(1, 400);
  fault.truncate_too = fault.call == "write" && draws.between(0, 2) == 0;
  return trial;
}

Verdict run_trial(Trial trial) {
  const testing::TemporaryFolder folder;
  trial.fault.folder = folder.path().string();
  Verdict verdict = run_target(trial.target, folder.path(), trial.fault);
  verdict.trial = fmt::format("{}, {}, told: \"{}\"", trial.target, to_text(trial.fault), verdict.words);
  verdict.rows = {{"file, call, error", row_of(trial)}};
  for (const char* ending : kEndings) verdict.count(ending, 0.0);
  return verdict;
}

}  // namespace strobe::storage
