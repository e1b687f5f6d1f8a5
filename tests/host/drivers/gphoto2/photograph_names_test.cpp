#include "host/drivers/gphoto2/photograph_names.hpp"

#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::gphoto2;

}  // namespace

TEST_GROUP(Gphoto2Names) {
  strobe::testing::TemporaryFolder folder;
};

TEST(Gphoto2Names, TellRawFilesFromOthers) {
  CHECK(file_kind("DSC_0001.NEF") == FileKind::raw);
  CHECK(file_kind("img_0001.cr3") == FileKind::raw);
  CHECK(file_kind("DSC_0001.TIF") == FileKind::developed);
  CHECK(file_kind("DSC_0001.JPG") == FileKind::jpeg);
  CHECK(file_kind("MVI_0001.MOV") == FileKind::other);
  CHECK(file_kind("") == FileKind::other);
}

TEST(Gphoto2Names, TheLastDigitsAreTheCamerasNumber) {
  LONGS_EQUAL(42, file_number("DSC_0042.NEF"));
  LONGS_EQUAL(4321, file_number("DSC04321.ARW"));
  LONGS_EQUAL(7, file_number("100_0007a.dng"));
  LONGS_EQUAL(-1, file_number("photo.nef"));
  LONGS_EQUAL(-1, file_number(".nef"));
  LONGS_EQUAL(-1, file_number("99999999999999999999.nef"));
}

TEST(Gphoto2Names, CannotLeadOutOfTheFolder) {
  CHECK_EQUAL("_.._.._etc_passwd", safe_name("../../etc/passwd"));
  CHECK_EQUAL("_", safe_name(""));
  CHECK_EQUAL("_.hidden.nef", safe_name(".hidden.nef"));
  CHECK_EQUAL("DSC_0001.NEF", safe_name("DSC_0001.NEF"));
  CHECK_EQUAL("a_b__c.nef", safe_name("a b\n/c.nef"));
}

TEST(Gphoto2Names, NeverMeetAFileThatIsThere) {
  CHECK_EQUAL("DSC_0001.NEF", free_name(folder.path(), "DSC_0001.NEF"));
  strobe::testing::write_text(folder / "DSC_0001.NEF", "x");
  CHECK_EQUAL("DSC_0001-2.NEF", free_name(folder.path(), "DSC_0001.NEF"));
  strobe::testing::write_text(folder / "DSC_0001-2.NEF", "x");
  CHECK_EQUAL("DSC_0001-3.NEF", free_name(folder.path(), "DSC_0001.NEF"));
}
