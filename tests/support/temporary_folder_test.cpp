#include "tests/support/temporary_folder.hpp"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe::testing;

TEST_GROUP(TemporaryFolder){};

TEST(TemporaryFolder, IsThereAndEmptyAndItsOwn) {
  const TemporaryFolder one;
  const TemporaryFolder other;
  CHECK(std::filesystem::is_empty(one.path()));
  CHECK(one.path() != other.path());
}

TEST(TemporaryFolder, GoesWithAllThatIsInIt) {
  std::filesystem::path path;
  {
    const TemporaryFolder folder;
    path = folder.path();
    std::filesystem::create_directories(folder / "a/b");
    write_text(folder / "a/b/c.txt", "text");
  }
  CHECK_EQUAL(std::getenv("STROBE_KEEP_FOLDERS") != nullptr, std::filesystem::exists(path));
}

TEST(TemporaryFolder, KeepsWhatIsWrittenByteForByte) {
  const TemporaryFolder folder;
  const std::string text("line\r\n\0end", 10);
  write_text(folder / "file", text);
  CHECK_EQUAL(text, read_text(folder / "file"));
}

TEST(TemporaryFolder, ComplainsOfAFileThatCannotBeWritten) {
  const TemporaryFolder folder;
  CHECK_THROWS(std::runtime_error, write_text(folder / "no/such/file", "text"));
}
