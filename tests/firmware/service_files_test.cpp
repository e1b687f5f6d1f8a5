#include "firmware/worker/service_files.hpp"

#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::firmware;

namespace {

Options with_rig_file(const char* path) {
  Options options;
  options.config = path;
  return options;
}

}  // namespace

TEST_GROUP(ServiceFiles){};

TEST(ServiceFiles, AreThoseOfTheShippedUnit) {
  const std::string unit = strobe::testing::read_text(STROBE_BUILD_DIR "/firmware/strobed.service");
  STRCMP_CONTAINS((std::string("LoadCredential=lab.key:") + kServiceKeyFile + "\n").c_str(), unit.c_str());
  STRCMP_CONTAINS(
      (std::string("--config ") + kServiceRigFile + " --session " + kServiceSession + "\n").c_str(),
      unit.c_str());
}

TEST(ServiceFiles, LetSystemdStopStrobedBeforeTheMachineSleeps) {
  const std::string unit = strobe::testing::read_text(STROBE_BUILD_DIR "/firmware/strobed.service");
  for (const char* line : {"\nConflicts=sleep.target\n", "\nBefore=sleep.target\n"})
    STRCMP_CONTAINS(line, unit.c_str());
}

TEST(ServiceFiles, AreCheckedByRootWithTheServicesRigFileWhereNothingElseIsNamed) {
  const Options checked = options_of_check(with_rig_file(kServiceRigFile), Rig{}, true);
  CHECK_EQUAL(kServiceKeyFile, checked.key_file);
  CHECK_EQUAL(kServiceSession, checked.session.string());
  CHECK_EQUAL("", key_note(checked, Rig{}));
  Options named = with_rig_file(kServiceRigFile);
  named.key_file = "/named";
  named.session = "/there";
  CHECK_EQUAL("/named", options_of_check(named, Rig{}, true).key_file);
  CHECK_EQUAL("/there", options_of_check(named, Rig{}, true).session.string());
  Rig rig;
  rig.key_file = "/of/rig";
  CHECK_EQUAL("", options_of_check(with_rig_file(kServiceRigFile), rig, true).key_file);
}

TEST(ServiceFiles, AreNotAnotherUsersOrAnotherRigFiles) {
  for (const bool root : {false, true})
    CHECK_EQUAL("", options_of_check(with_rig_file("rig.toml"), Rig{}, root).key_file);
  const Options user = options_of_check(with_rig_file(kServiceRigFile), Rig{}, false);
  CHECK_EQUAL("", user.key_file);
  STRCMP_CONTAINS("the service has /etc/strobe/lab.key", key_note(user, Rig{}).c_str());
  CHECK_EQUAL("", key_note(with_rig_file("rig.toml"), Rig{}));
}
