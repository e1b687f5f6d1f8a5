// Files read by their lines, whatever their size, and what cannot be read told from what is not there.
#include "common/config/files.hpp"

#include <string>
#include <vector>

#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;

}  // namespace

TEST_GROUP(FilesByLines) {
  testing::TemporaryFolder folder;
  std::vector<std::string> lines;
  Result<bool> read(const char* name) {
    lines.clear();
    return config::read_lines(folder / name, [this](std::string_view line, bool ended) {
      lines.push_back(std::string(line) + (ended ? "|" : "~"));
    });
  }
};

TEST(FilesByLines, AreHandedOnWithWhetherTheyHaveAnEnd) {
  testing::write_text(folder / "some", "one\n\n" + std::string(70'000, 'x') + "\nlast");
  CHECK_TRUE(read("some").value());
  LONGS_EQUAL(4, lines.size());
  CHECK_EQUAL("one|", lines[0]);
  CHECK_EQUAL("|", lines[1]);
  LONGS_EQUAL(70'001, lines[2].size());
  CHECK_EQUAL("last~", lines[3]);
}

TEST(FilesByLines, AFileMayBeOfAnySizeALineMayNot) {
  std::string many;
  for (int i = 0; i < 300'000; ++i) many += std::string(60, 'x') + "\n";
  testing::write_text(folder / "many", many);
  CHECK_TRUE(read("many").value());
  LONGS_EQUAL(300'000, lines.size());
  testing::write_text(folder / "sparse", "one\n");
  std::filesystem::resize_file(folder / "sparse", std::uintmax_t{1} << 40);
  CHECK_EQUAL((folder / "sparse").string() + ": a line is longer than 1 MB", read("sparse").error().message);
}

TEST(FilesByLines, WhatCannotBeReadIsNotTakenForWhatIsNotThere) {
  CHECK_FALSE(read("nothing").value());
  CHECK_FALSE(config::read_file_if_any(folder / "nothing").value().has_value());
  std::filesystem::create_directory(folder / "directory");
  STRCMP_CONTAINS("directory: Is a directory", read("directory").error().message.c_str());
  STRCMP_CONTAINS("directory: Is a directory",
                  config::read_file_if_any(folder / "directory").error().message.c_str());
  std::filesystem::create_symlink("loop", folder / "loop");
  STRCMP_CONTAINS("loop: ", read("loop").error().message.c_str());
  STRCMP_CONTAINS("loop: ", config::read_file_if_any(folder / "loop").error().message.c_str());
}
