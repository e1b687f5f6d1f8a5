#include "tests/storage/trial.hpp"

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"
#include "tests/storage/session_trial.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::storage {
namespace {

namespace fs = std::filesystem;
using testing::DiskFault;

constexpr std::array kErrors{ENOSPC, EROFS, EDQUOT, EIO, ESTALE, EFBIG, EMFILE};

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  int number(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  template <typename Choices>
  auto choice(const Choices& choices) {
    return choices[static_cast<std::size_t>(number(0, static_cast<int>(choices.size()) - 1))];
  }

 private:
  std::mt19937_64 random_;
};

/// Where and when, in a session: which calls there are, and how many of them a series of three shots makes.
struct Place {
  const char* file;
  const char* call;
  int calls;
};
constexpr std::array kSessionPlaces{Place{"host-20260131T10", "write", 120},
                                    Place{"host-20260131T10", "write", 120},
                                    Place{"host-20260131T10", "write", 120},
                                    Place{"host-20260131T10", "fsync", 4},
                                    Place{"host-20260131T10", "close", 1},
                                    Place{"host-20260131T10", "open", 1},
                                    Place{"results.csv", "write", 3},
                                    Place{"results.csv", "write", 3},
                                    Place{"results.csv", "fsync", 4},
                                    Place{"results.csv", "close", 1},
                                    Place{"results.csv", "open", 1},
                                    Place{"session.lock", "flock", 1},
                                    Place{"flashes.csv", "write", 3},
                                    Place{"flashes.csv", "write", 3},
                                    Place{"flashes.csv", "fsync", 4},
                                    Place{"flashes.csv", "close", 1},
                                    Place{"flashes.csv", "open", 1},
                                    Place{"", "fsync", 14},
                                    Place{"", "memory", 20'000},
                                    Place{"", "memory", 20'000},
                                    Place{"", "remove folder", 14},
                                    Place{"", "rename folder", 14},
                                    Place{"results.csv", "remove file", 14},
                                    Place{"host-20260131T100000Z.lcmlog", "remove file", 14},
                                    Place{"", "write", 130},
                                    Place{"", "write", 130},
                                    Place{"", "open", 4}};
constexpr std::array kFilePlaces{Place{"", "write", 3}, Place{"", "fsync", 2}, Place{"", "close", 2},
                                 Place{"", "rename", 1}, Place{"", "open", 1}};
constexpr std::array kKeyPlaces{Place{"", "write", 1}, Place{"", "fsync", 2}, Place{"", "close", 2},
                                Place{"", "link", 1}};

const std::string kOld(3'000'000, 'o');
const std::string kNew(2'500'000, 'n');

void write_plainly(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// Of a file written in one go: told is what the writer said, empty if it is stored.
Verdict judge_file(const fs::path& folder, const fs::path& path, const std::string& told,
                   const std::string& before, const std::string& wanted) {
  Verdict verdict;
  const std::string now = testing::read_text(path);
  if (told.empty() && now != wanted) verdict.violation = "told as stored, and is not";
  if (now != before && now != wanted) verdict.violation = "neither the old file nor the new one";
  if (!told.empty() && told.find(path.filename().string()) == told.npos)
    verdict.violation = "the file is not named";
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (name.ends_with(".new")) verdict.violation = "a draft is left over";
  }
  verdict.told = told;
  const bool reached = testing::disk_faults_injected() > 0;
  verdict.ending = !reached        ? Ending::not_reached
                   : told.empty()  ? Ending::harmless
                   : now == wanted ? Ending::told_stored
                                   : Ending::refused;
  if (!reached && !told.empty()) verdict.violation = "told a failure that was none";
  return verdict;
}

Verdict run_replaced(const fs::path& folder, const DiskFault& fault) {
  const fs::path path = folder / "camera.toml";
  write_plainly(path, kOld);
  testing::set_disk_fault(fault);
  const auto written = config::write_file(path, kNew);
  testing::clear_disk_fault();
  return judge_file(folder, path, written ? "" : written.error().message, kOld, kNew);
}

Verdict run_copied(const fs::path& folder, const DiskFault& fault) {
  const fs::path from = folder / "exposure.tif", path = folder / "shot-0001-exposure.tif";
  write_plainly(from, kNew);
  testing::set_disk_fault(fault);
  const auto copied = config::copy_file(from, path);
  testing::clear_disk_fault();
  return judge_file(folder, path, copied ? "" : copied.error().message, "", kNew);
}

Verdict run_key(const fs::path& folder, const DiskFault& fault) {
  const fs::path path = folder / "lab.key";
  testing::set_disk_fault(fault);
  const auto made = authentication::make_key_file(path);
  testing::clear_disk_fault();
  const std::string wanted = made                                  ? made->key.text() + "\n"
                             : authentication::read_key_file(path) ? testing::read_text(path)
                                                                   : "a key";
  Verdict verdict = judge_file(folder, path, made ? "" : made.error().message, "", wanted);
  if (made && !authentication::read_key_file(path)) verdict.violation = "the key cannot be read";
  return verdict;
}

}  // namespace

const char* name(Ending ending) {
  constexpr std::array kNames{"not reached", "harmless", "refused", "told, stored after all",
                              "told, unstored named"};
  return kNames[static_cast<std::size_t>(ending)];
}

Trial draw(std::uint64_t seed) {
  Draws draws(seed);
  Trial trial;
  trial.seed = seed;
  const int kind = draws.number(0, 9);
  trial.target = kind < 7 ? "session" : kind == 7 ? "replaced file" : kind == 8 ? "copied file" : "key";
  const Place place = kind < 7   ? draws.choice(kSessionPlaces)
                      : kind < 9 ? draws.choice(kFilePlaces)
                                 : draws.choice(kKeyPlaces);
  DiskFault& fault = trial.fault;
  fault.file = place.file;
  fault.call = place.call;
  fault.nth = draws.number(1, place.calls);
  fault.times = draws.choice(std::array{1, 1, 2, 5, 20, 1'000'000});
  fault.error = draws.choice(kErrors);
  if (fault.call == "write" && draws.number(0, 3) == 0) fault.error = EINTR;
  if (fault.error == EINTR && fault.times > 20) fault.times = 20;  // for ever, no program would come back
  if (fault.call == "write" && draws.number(0, 1) == 0) fault.short_bytes = draws.number(1, 400);
  fault.truncate_too = fault.call == "write" && draws.number(0, 2) == 0;
  return trial;
}

Verdict run_trial(Trial trial) {
  const testing::TemporaryFolder folder;
  trial.fault.folder = folder.path().string();
  if (trial.target == "session") {
    fs::create_directory(folder / "session");
    return run_session(folder / "session", trial.fault);
  }
  if (trial.target == "replaced file") return run_replaced(folder.path(), trial.fault);
  return trial.target == "copied file" ? run_copied(folder.path(), trial.fault)
                                       : run_key(folder.path(), trial.fault);
}

}  // namespace strobe::storage
