// What strobe-raw makes of a camera's RAW file, and how the host comes to it. libraw decodes the files, the simulator
// writes them: they share no code.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/digitize/image/photograph.hpp"
#include "host/external/raw_file.hpp"
#include "tests/host/raw/dng_pictures.hpp"
#include "tests/support/error_of.hpp"

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(RawFile) {
  TemporaryFolder folder;

  /// Replaces the 16-bit value of a tag of the DNG's directory, of type SHORT or LONG.
  static std::string with_tag(std::string file, unsigned tag, unsigned value) {
    const auto at = [&](std::size_t i) { return static_cast<unsigned char>(file[i]); };
    std::size_t entry = at(4) + 256U * at(5) + 65536U * at(6);
    for (int left = at(entry) + 256 * at(entry + 1); left > 0; --left) {
      const std::size_t here = entry + 2 + 12 * static_cast<std::size_t>(left - 1);
      if (at(here) + 256U * at(here + 1) != tag) continue;
      file[here + 8] = static_cast<char>(value & 255U);
      file[here + 9] = static_cast<char>(value >> 8);
      return file;
    }
    FAIL("no such tag");
    return file;
  }

  void check_refusal(const std::string& why, const std::string& file) {
    const std::string message = error_of(converted(folder, file));
    CHECK_TEXT(message.starts_with("strobe-raw: "), message.c_str());
    STRCMP_CONTAINS(why.c_str(), message.c_str());
    LONGS_EQUAL(1, std::ranges::count(message, '\n'));
  }
};

TEST(RawFile, BecomesAMosaicOfTheSensorsNumbers) {
  const image::Raster picture = raw_picture();
  for (const auto& colours : {std::array<std::uint8_t, 4>{0, 1, 1, 2}, {1, 0, 2, 1}, {2, 1, 1, 0}, {1, 2, 0, 1}}) {
    const image::Mosaic mosaic{colours, kRawMosaic.black, kRawMosaic.white};
    const auto raster = converted(folder, dng_of(picture, mosaic));
    CHECK_TEXT(raster.has_value(), error_of(raster).c_str());
    CHECK(raster->mosaic == mosaic);
    LONGS_EQUAL(kRawWidth, raster->width());
    MEMCMP_EQUAL(picture.row(0), raster->row(0), picture.size_bytes());
  }
}

TEST(RawFile, IsNotTurned) {
  const image::Raster picture = raw_picture();
  constexpr unsigned kOrientation = 274, kQuarterTurn = 6;
  const auto raster = converted(folder, with_tag(dng_of(picture), kOrientation, kQuarterTurn));
  MEMCMP_EQUAL(picture.row(0), raster->row(0), picture.size_bytes());
}

// The slopes rise by 22 and 14 from a pixel to the next of its colour, the noise is of 12: a mended one is the
// mean of opposite ones, so that it is off by no more than the noise.
TEST(RawFile, HasItsDeadAndHotPixelsMendedFromTheirOwnColour) {
  const image::Raster picture = raw_picture();
  image::Raster defective = raw_picture();
  const int places[][3] = {{10, 10, 0}, {21, 12, 4095}, {30, 31, 4000}, {41, 40, 0}};
  for (const auto& [x, y, number] : places) set_number(defective, x, y, number);
  const auto raster = converted(folder, dng_of(defective));
  for (const auto& [x, y, number] : places)
    CHECK(std::abs(raw_number(*raster, x, y) - raw_number(picture, x, y)) <= 13);
  for (const auto& [x, y, number] : places) set_number(defective, x, y, raw_number(*raster, x, y));
  MEMCMP_EQUAL(defective.row(0), raster->row(0), defective.size_bytes());
}

// A lens blurs whatever it draws over more than one pixel of a colour: a line two pixels wide stays.
TEST(RawFile, KeepsFineLines) {
  image::Raster picture = raw_picture();
  for (int y = 0; y < kRawHeight; ++y)
    for (const int x : {20, 21}) set_number(picture, x, y, 3500);
  const auto raster = converted(folder, dng_of(picture));
  MEMCMP_EQUAL(picture.row(0), raster->row(0), picture.size_bytes());
}

TEST(RawFile, ThatIsNoneOrDamagedOrOfAnotherKindIsRefusedInALine) {
  const std::string whole = dng_of(raw_picture());
  check_refusal("not a RAW file that LibRaw", std::string(100'000, 'x'));
  check_refusal("cut short", "");
  constexpr unsigned kCompression = 259, kMeaning = 262, kLinear = 34892, kSamples = 277;
  check_refusal("", with_tag(whole, kCompression, 99));
  check_refusal("cut short", with_tag(with_tag(whole, kMeaning, kLinear), kSamples, 3));
  // LibRaw knows none of fewer than 22 x 22 pixels.
  std::string linear = with_tag(with_tag(whole, kMeaning, kLinear), kSamples, 3);
  for (const unsigned side : {256, 257}) linear = with_tag(linear, side, 24);
  check_refusal("mixed colours", linear);
}

TEST(RawFile, IsAskedForInOneWay) {
  for (const auto& words : std::vector<std::vector<std::string>>{{}, {"a"}, {"a", "b", "c"}}) {
    std::vector<std::string> all{raw_program()};
    all.insert(all.end(), words.begin(), words.end());
    const auto run = run_program(all);
    LONGS_EQUAL(2, run.status->code);
    CHECK_EQUAL("strobe-raw: usage: strobe-raw FILE OUT.tif\n", run.err);
  }
  check_prints(run_program({raw_program(), "--help"}), {"usage: strobe-raw FILE OUT.tif"});
}

TEST(RawFile, ThatCannotBeWrittenIsTold) {
  write_text(folder / "a.dng", dng_of(raw_picture()));
  const auto run = run_program({raw_program(), folder / "a.dng", folder / "no/a.tif"});
  LONGS_EQUAL(1, run.status->code);
  STRCMP_CONTAINS("no/a.tif: cannot be written", run.err.c_str());
}

TEST(RawFile, IsReadAsAPhotographLikeItsMosaic) {
  const image::Raster picture = raw_picture();
  write_text(folder / "a.DNG", dng_of(picture));
  write_text(folder / "b.tif", dng_of(picture));  // whatever its name
  const auto mosaic = image::encode_tiff(picture.pixels(), {.mosaic = kRawMosaic});
  const auto expected = digitize::decode_photograph(*mosaic, "mosaic");
  for (const char* name : {"a.DNG", "b.tif"}) {
    const auto photograph = digitize::load_photograph(folder / name);
    CHECK_TEXT(photograph.has_value(), error_of(photograph).c_str());
    CHECK_EQUAL(0.0, cv::norm(expected->intensity, photograph->intensity, cv::NORM_INF));
    CHECK_EQUAL((folder / name).string(), photograph->name);
  }
}

TEST(RawFile, ThatIsNoneSaysSoWithItsName) {
  write_text(folder / "a.nef", std::string(100'000, 'x'));
  const std::string message = error_of(digitize::load_photograph(folder / "a.nef"));
  STRCMP_CONTAINS((folder / "a.nef: not a RAW file that LibRaw").c_str(), message.c_str());
}

TEST(RawFile, IsKnownByItsName) {
  for (const char* name : {"a.cr2", "DSC_1.NEF", "x/y.Cr3", "a.arw", "a.dng", "a.RAF"}) CHECK(external::is_raw_name(name));
  for (const char* name : {"a.tif", "a.jpg", "dng", "cr2.png", ""}) CHECK_FALSE(external::is_raw_name(name));
}
