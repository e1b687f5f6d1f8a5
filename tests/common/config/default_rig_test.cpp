#include "common/config/default_rig.hpp"

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using strobe::config::example_remark;
using strobe::config::rig_file_or_example;

TEST_GROUP(DefaultRig) {
  strobe::testing::TemporaryFolder folder;
  void setup() override { ::setenv("STROBE_SHARE", folder.path().c_str(), 1); }
  void teardown() override { ::unsetenv("STROBE_SHARE"); }
};

TEST(DefaultRig, IsTheNamedFileWhereOneIsNamed) {
  CHECK_EQUAL("lab.toml", rig_file_or_example("lab.toml", "--rig").value_or(""));
  CHECK_EQUAL("", example_remark("lab.toml", "--rig"));
}

TEST(DefaultRig, IsElseTheExampleInTheShareFolderAndSaysSo) {
  const std::string example = folder / "rig.toml";
  CHECK_EQUAL(example, rig_file_or_example("", "--rig").value_or(""));
  CHECK_EQUAL("no --config given: taking the example " + example, example_remark("", "--config"));
}

TEST(DefaultRig, FailsWithBothReasonsWhereThereIsNoShareFolder) {
  std::filesystem::remove(folder.path());
  const auto found = rig_file_or_example("", "--rig");
  CHECK_FALSE(found.has_value());
  STRCMP_CONTAINS("no --rig given, and ", found.error().message.c_str());
  STRCMP_CONTAINS(folder.path().c_str(), found.error().message.c_str());
}
