// Tars as this project and as others make them, those who mean harm among them.
#include <archive.h>
#include <archive_entry.h>

#include <filesystem>
#include <functional>
#include <string>

#include "host/interlaboratory/tape_archive.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::interlaboratory;
using strobe::testing::read_text;
using strobe::testing::write_text;
namespace fs = std::filesystem;

using Change = std::function<void(archive_entry*)>;

/// An archive by libarchive itself: a file "a/b" with the text, changed.
void write_foreign(const fs::path& path, const Change& change, bool is_compressed = false, int times = 1) {
  archive* writer = archive_write_new();
  archive_write_set_format_pax(writer);
  if (is_compressed) archive_write_add_filter_gzip(writer);
  archive_write_open_filename(writer, path.c_str());
  for (int i = 0; i < times; ++i) {
    archive_entry* entry = archive_entry_new();
    archive_entry_set_pathname(entry, "a/b");
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    archive_entry_set_size(entry, 4);
    change(entry);
    archive_write_header(writer, entry);
    archive_write_data(writer, "text", 4);
    archive_entry_free(entry);
  }
  archive_write_free(writer);
}

}  // namespace

TEST_GROUP(TapeArchive) {
  strobe::testing::TemporaryFolder folder;

  std::string refusal() {
    const auto unpacked = unpack(folder / "foreign.tar", folder / "into");
    CHECK_FALSE(unpacked.has_value());
    return unpacked.error().message;
  }
};

TEST(TapeArchive, GivesBackWhatWasPackedWithTheSameBytesEachTime) {
  const std::string large(300'000, 'x');
  write_text(folder / "large", large);
  const std::vector<PackedFile> files{{"s/empty", "", ""}, {"s/photographs/grün.tif", folder / "large", ""},
                                      {"s/" + std::string(240, 'n'), "", "long"}};
  CHECK_TRUE(pack(folder / "one.tar", files, 1'769'851'800).has_value());
  CHECK_TRUE(pack(folder / "two.tar", files, 1'769'851'800).has_value());
  CHECK(read_text(folder / "one.tar") == read_text(folder / "two.tar"));
  const auto names = unpack(folder / "one.tar", folder / "into");
  CHECK_TEXT(names.has_value(), names ? "" : names.error().message.c_str());
  CHECK(*names == std::vector<std::string>({"s/empty", "s/photographs/grün.tif", "s/" + std::string(240, 'n')}));
  CHECK(read_text(folder / "into/s/photographs/grün.tif") == large);
  CHECK_EQUAL(std::string("long"), read_text(folder / "into/s" / std::string(240, 'n')));
  CHECK_FALSE(fs::exists(folder / "one.tar.unfinished"));
}

TEST(TapeArchive, IsNotThereWhereAFileIsMissing) {
  const auto packed = pack(folder / "one.tar", {{"s/a", folder / "absent", ""}}, 0);
  STRCMP_CONTAINS("absent: cannot be read", packed.error().message.c_str());
  CHECK_FALSE(fs::exists(folder / "one.tar") || fs::exists(folder / "one.tar.unfinished"));
}

TEST(TapeArchive, RefusesNamesThatLeadElsewhere) {
  for (const char* name : {"../b", "a/../../b", "/tmp/b", "a//b", "./b", "a/", "a/b\nc", "a\\b", ""})
    CHECK_FALSE_TEXT(is_safe_name(name), name);
  CHECK(is_safe_name("a/..b/c") && is_safe_name("grün"));
  for (const char* name : {"../b", "/strobe-test-absolute"}) {
    write_foreign(folder / "foreign.tar", [&](archive_entry* entry) { archive_entry_set_pathname(entry, name); });
    STRCMP_CONTAINS("leads out of the folder", refusal().c_str());
  }
  CHECK_FALSE(fs::exists(folder / "b") || fs::exists("/strobe-test-absolute"));
}

TEST(TapeArchive, RefusesLinksAndDevices) {
  write_foreign(folder / "foreign.tar", [](archive_entry* entry) {
    archive_entry_set_filetype(entry, AE_IFLNK);
    archive_entry_set_symlink(entry, "/etc");
  });
  STRCMP_CONTAINS("\"a/b\": is a link", refusal().c_str());
  write_foreign(folder / "foreign.tar", [](archive_entry* entry) { archive_entry_set_hardlink(entry, "/etc/passwd"); });
  STRCMP_CONTAINS("is a link", refusal().c_str());
  write_foreign(folder / "foreign.tar", [](archive_entry* entry) { archive_entry_set_filetype(entry, AE_IFIFO); });
  STRCMP_CONTAINS("is no file", refusal().c_str());
  CHECK(!fs::exists(folder / "into") || fs::is_empty(folder / "into"));
}

TEST(TapeArchive, RefusesMoreThanItHolds) {
  // A hole of a gigabyte, of which the archive has no byte.
  write_foreign(folder / "foreign.tar", [](archive_entry* entry) {
    archive_entry_set_size(entry, 1'000'000'000);
    archive_entry_sparse_add_entry(entry, 0, 4);
  });
  STRCMP_CONTAINS("larger than the archive", refusal().c_str());
  write_foreign(folder / "foreign.tar", [](archive_entry*) {}, true);
  STRCMP_CONTAINS("no tar archive", refusal().c_str());
  write_foreign(folder / "foreign.tar", [](archive_entry*) {}, false, 2);
  STRCMP_CONTAINS("\"a/b\": stands there twice", refusal().c_str());
}

TEST(TapeArchive, RefusesWhatIsCutOff) {
  write_text(folder / "large", std::string(100'000, 'x'));
  CHECK_TRUE(pack(folder / "foreign.tar", {{"s/large", folder / "large", ""}}, 0).has_value());
  write_text(folder / "foreign.tar", read_text(folder / "foreign.tar").substr(0, 50'000));
  STRCMP_CONTAINS("\"s/large\": ", refusal().c_str());
  write_text(folder / "foreign.tar", "");
  CHECK(!refusal().empty());
}
