#include "common/authentication/key_file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::authentication;
namespace fs = std::filesystem;

namespace {

constexpr const char* kVariables[] = {"STROBE_KEY_FILE", "CREDENTIALS_DIRECTORY", "XDG_CONFIG_HOME", "HOME"};
const std::string kText(64, 'a');

}  // namespace

TEST_GROUP(KeyFile) {
  strobe::testing::TemporaryFolder folder;

  void setup() override {
    for (const char* variable : kVariables) unsetenv(variable);
    setenv("HOME", folder.path().c_str(), 1);
  }
  void teardown() override {
    for (const char* variable : kVariables) unsetenv(variable);
  }

  fs::path file(const std::string& name, const std::string& text = kText + "\n", mode_t mode = 0600) const {
    const fs::path path = folder / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    chmod(path.c_str(), mode);
    return path;
  }
  static mode_t mode_of(const fs::path& path) {
    struct stat status {};
    stat(path.c_str(), &status);
    return status.st_mode & 07777;
  }
  static void expect(const char* what, const fs::path& path) {
    const auto key = read_key_file(path);
    CHECK_FALSE_TEXT(key.has_value(), path.c_str());
    STRCMP_CONTAINS(path.c_str(), key.error().message.c_str());
    STRCMP_CONTAINS(what, key.error().message.c_str());
    CHECK_EQUAL(std::string::npos, key.error().message.find('\n'));
    CHECK_EQUAL(std::string::npos, key.error().message.find(kText.substr(0, 8)));
  }
};

TEST(KeyFile, IsReadIfOnlyItsOwnerCan) {
  CHECK_EQUAL(kText, read_key_file(file("a"))->text());
  CHECK_EQUAL(kText, read_key_file(file("b", kText, 0400))->text());
}

TEST(KeyFile, IsRefusedIfOthersCanReadOrChangeIt) {
  for (const mode_t mode : {0640, 0620, 0610, 0604, 0602, 0644, 0660, 0666, 0777}) {
    const fs::path path = file("loose", kText, mode);
    expect(("chmod 600 " + path.string()).c_str(), path);
  }
}

TEST(KeyFile, IsRefusedIfItIsNotThereOrNoFileOrNoKey) {
  expect("strobe key --new", folder / "none");
  expect("regular file", folder.path());
  expect("regular file", "/dev/zero");
  expect("64 hexadecimal digits", file("empty", ""));
  expect("64 hexadecimal digits", file("letters", std::string(64, 'x')));
  expect("64 hexadecimal digits", file("long", std::string(128, 'a')));
}

TEST(KeyFile, IsRefusedIfItIsAnothers) {
  if (geteuid() != 0) return;  // only root can give a file away
  const fs::path path = file("given");
  LONGS_EQUAL(0, chown(path.c_str(), 12345, 12345));
  expect("chown 0", path);
}

TEST(KeyFile, IsJudgedBehindASymbolicLink) {
  fs::create_symlink(file("good"), folder / "to_good");
  CHECK_TRUE(read_key_file(folder / "to_good").has_value());
  fs::create_symlink(file("loose", kText, 0644), folder / "to_loose");
  expect("chmod 600", folder / "to_loose");
  fs::create_symlink(folder / "nowhere", folder / "to_nothing");
  expect("no such key", folder / "to_nothing");
}

TEST(KeyFile, IsMadeForItsOwnerAloneAndNeverTwice) {
  const mode_t before = umask(0);
  const auto made = make_key_file(folder / "new" / "lab.key");
  umask(before);
  CHECK_TRUE(made.has_value());
  CHECK_TRUE(made->made);
  LONGS_EQUAL(0600, mode_of(made->path));
  LONGS_EQUAL(0755, mode_of(made->path.parent_path()));  // a rig file beside it is for the service
  CHECK_EQUAL(made->key.text(), read_key_file(made->path)->text());
  STRCMP_CONTAINS("there is a key already", make_key_file(made->path).error().message.c_str());
  CHECK_EQUAL(made->key.text(), read_key_file(made->path)->text());
  LONGS_EQUAL(1, std::distance(fs::directory_iterator(made->path.parent_path()), {}));
}

TEST(KeyFile, IsNotLeftHalfWritten) {
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  const rlimit ten_bytes{10, usual.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &ten_bytes);
  const auto made = make_key_file(folder / "lab.key");
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, handler);
  CHECK_FALSE(made.has_value());
  STRCMP_CONTAINS("lab.key: the key cannot be written: File too large", made.error().message.c_str());
  CHECK_TRUE(fs::is_empty(folder.path()));
}

TEST(KeyFile, IsFoundInTheOrderThatTheHeaderSays) {
  const std::string of[] = {std::string(64, '1'), std::string(64, '2'), std::string(64, '3'),
                            std::string(64, '4'), std::string(64, '5')};
  KeyPlaces places{file("option", of[0]), file("rig", of[1])};
  setenv("STROBE_KEY_FILE", file("variable", of[2]).c_str(), 1);
  setenv("CREDENTIALS_DIRECTORY", file("credentials/lab.key", of[3], 0440).parent_path().c_str(), 1);
  file(".config/strobe/lab.key", of[4]);
  const auto found = [&] { return find_key(places).value().key.text(); };
  CHECK_EQUAL(of[0], found());
  places.option.clear();
  CHECK_EQUAL(of[1], found());
  places.rig_file.clear();
  CHECK_EQUAL(of[2], found());
  unsetenv("STROBE_KEY_FILE");
  CHECK_EQUAL(of[3], found());
  fs::remove(folder / "credentials/lab.key");
  CHECK_EQUAL(of[4], found());
}

TEST(KeyFile, ThatIsNamedIsNeitherMadeNorReplacedByAnother) {
  file(".config/strobe/lab.key");
  STRCMP_CONTAINS("no such key", find_key({folder / "none", ""}).error().message.c_str());
  STRCMP_CONTAINS("chmod 600", find_key({"", file("loose", kText, 0644)}).error().message.c_str());
}

TEST(KeyFile, OfTheHomeIsMadeOnceHoweverManyProgramsStartTogether) {
  constexpr int kPrograms = 16;
  std::vector<std::string> texts(kPrograms);
  {
    std::vector<std::jthread> programs;
    for (int i = 0; i < kPrograms; ++i) {
      programs.emplace_back([&text = texts[static_cast<std::size_t>(i)]] {
        const auto found = find_key({});
        text = found ? found->key.text() : found.error().message;
      });
    }
  }
  LONGS_EQUAL(1, std::set<std::string>(texts.begin(), texts.end()).size());
  LONGS_EQUAL(64, texts[0].size());
  CHECK_EQUAL(texts[0], read_key_file(folder / ".config/strobe/lab.key")->text());
}

TEST(KeyFile, OfTheHomeIsRefusedIfOthersCanReadIt) {
  file(".config/strobe/lab.key", kText, 0644);
  STRCMP_CONTAINS("chmod 600", find_key({}).error().message.c_str());
}

TEST(KeyFile, ACredentialMayBeReadByItsGroupButChangedByNobodyElse) {
  // systemd shows a user's access list as the group's rights.
  const auto credential_of_mode = [this](mode_t mode) {
    fs::remove(folder / "credentials/lab.key");
    setenv("CREDENTIALS_DIRECTORY", file("credentials/lab.key", kText, mode).parent_path().c_str(), 1);
    const auto found = find_key({});
    return found ? found->key.text() : found.error().message;
  };
  for (const mode_t mode : {0400, 0440, 0600, 0640}) CHECK_EQUAL(kText, credential_of_mode(mode));
  for (const mode_t mode : {0460, 0420, 0444, 0442, 0441, 0404, 0402})
    STRCMP_CONTAINS("others can read or change", credential_of_mode(mode).c_str());
}

TEST(KeyFile, OfACredentialThatCannotBeReadIsNotReplacedByAnother) {
  setenv("CREDENTIALS_DIRECTORY", (folder / "none").c_str(), 1);
  const auto gone = find_key({});
  CHECK_FALSE(gone.has_value());
  STRCMP_CONTAINS("none/lab.key: the key in $CREDENTIALS_DIRECTORY cannot be read: No such file",
                  gone.error().message.c_str());
  fs::create_symlink(folder / "nowhere", fs::path(file("credentials/other")).parent_path() / "lab.key");
  setenv("CREDENTIALS_DIRECTORY", (folder / "credentials").c_str(), 1);
  STRCMP_CONTAINS("no such key", find_key({}).error().message.c_str());
  CHECK_FALSE(fs::exists(folder / ".config"));
}

TEST(KeyFile, OfACredentialInAClosedFolderIsNotReplacedByAnother) {
  if (geteuid() != 0) return;  // root alone can become somebody who may not look into it
  chmod(folder.path().c_str(), 0755);
  const fs::path closed = file("credentials/lab.key").parent_path();
  chmod(closed.c_str(), 0700);
  setenv("CREDENTIALS_DIRECTORY", closed.c_str(), 1);
  const pid_t child = fork();
  if (child == 0) {
    const bool other = setgid(65534) == 0 && setuid(65534) == 0;
    const auto found = find_key({});
    _exit(other && !found && found.error().message.find("Permission denied") != std::string::npos ? 0 : 1);
  }
  int status = -1;
  LONGS_EQUAL(child, waitpid(child, &status, 0));
  LONGS_EQUAL(0, status);
}

TEST(KeyFile, WithoutAHomeThatCanBeWrittenMustBeNamed) {
  file("no_folder");
  setenv("HOME", (folder / "no_folder").c_str(), 1);
  const auto found = find_key({});
  CHECK_FALSE(found.has_value());
  STRCMP_CONTAINS("--key-file", found.error().message.c_str());
  STRCMP_CONTAINS("no_folder", found.error().message.c_str());
}
