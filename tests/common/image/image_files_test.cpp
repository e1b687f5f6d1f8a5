// Pictures read are those that other programs wrote; pictures written come back.
#include "common/image/image_files.hpp"

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "tests/common/image/reference_files.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::image;
using strobe::testing::reference_bytes;

// As in make_references.py.
constexpr int kWidth = 37, kHeight = 21;
int grey(int x, int y) { return (7 * x + 13 * y) % 256; }
int wide(int x, int y) { return (2711 * x + 977 * y) % 65536; }
int black(int x, int y) { return (x / 3 + y / 2) % 2 != 0 ? 255 : 0; }
int colour(int x, int y, int c) {
  return c == 0 ? grey(x, y) : c == 1 ? (x * x + 3 * y) % 256 : (255 - 5 * x + 11 * y + 256) % 256;
}
int wide_colour(int x, int y, int c) {
  return c == 0 ? wide(x, y) : c == 1 ? (65535 - 31 * x * y) % 65536 : (12345 + 511 * x + 3 * y) % 65536;
}

int number_at(const Raster& raster, int x, int y, int c) {
  const std::uint8_t* at = raster.row(y) + raster.pixel_bytes() * static_cast<std::size_t>(x);
  if (raster.bits() == 8) return at[c];
  std::uint16_t number = 0;
  std::memcpy(&number, at + 2 * c, 2);
  return number;
}

using Number = std::function<int(int x, int y, int c)>;

struct Expected {
  int channels;
  int bits;
  Number number;
};

const Expected kGrey{1, 8, [](int x, int y, int) { return grey(x, y); }};
const Expected kWide{1, 16, [](int x, int y, int) { return wide(x, y); }};
const Expected kBlack{1, 8, [](int x, int y, int) { return black(x, y); }};
const Expected kColour{3, 8, colour};
const Expected kWideColour{3, 16, wide_colour};

/// Of a picture wider and higher than the reference's, if it was turned.
void check(const std::string& name, const Raster& raster, const Expected& expected, bool turned = false) {
  LONGS_EQUAL_TEXT(turned ? kHeight : kWidth, raster.width(), name.c_str());
  LONGS_EQUAL_TEXT(turned ? kWidth : kHeight, raster.height(), name.c_str());
  LONGS_EQUAL_TEXT(expected.channels, raster.channels(), name.c_str());
  LONGS_EQUAL_TEXT(expected.bits, raster.bits(), name.c_str());
  for (int y = 0; y < raster.height(); ++y)
    for (int x = 0; x < raster.width(); ++x)
      for (int c = 0; c < raster.channels(); ++c)
        LONGS_EQUAL_TEXT(expected.number(x, y, c), number_at(raster, x, y, c), name.c_str());
}

Raster read(const std::string& name) {
  auto raster = decode(reference_bytes(name));
  CHECK_TEXT(raster.has_value(), (name + ": " + (raster ? "" : raster.error().message)).c_str());
  return std::move(*raster);
}

/// A little-endian TIFF file with another value of a tag that is a 16-bit number.
std::vector<std::uint8_t> with_tag(const std::string& name, int tag, int value) {
  auto bytes = reference_bytes(name);
  const auto number = [&](std::size_t at) { return bytes[at] | bytes[at + 1] << 8; };
  const auto directory = static_cast<std::size_t>(number(4) | number(6) << 16);
  for (int i = 0; i < number(directory); ++i) {
    const std::size_t entry = directory + 2 + 12 * static_cast<std::size_t>(i);
    if (number(entry) != tag) continue;
    bytes[entry + 8] = static_cast<std::uint8_t>(value);
    return bytes;
  }
  FAIL((name + ": no such tag").c_str());
  return bytes;
}

void check_files(const Expected& expected, const std::vector<std::string>& names) {
  for (const std::string& name : names) check(name, read(name), expected);
}

void check_same(const std::string& name, const std::string& other_program) {
  const Raster expected = read(other_program);
  check(name, read(name), {expected.channels(), expected.bits(), [&](int x, int y, int c) {
                             return number_at(expected, x, y, c);
                           }});
}

Raster picture(const Expected& expected) {
  Raster raster(kWidth, kHeight, expected.channels, expected.bits);
  for (int y = 0; y < kHeight; ++y) {
    for (int i = 0; i < kWidth * expected.channels; ++i) {
      const auto number =
          static_cast<std::uint16_t>(expected.number(i / expected.channels, y, i % expected.channels));
      if (expected.bits == 8)
        raster.row(y)[i] = static_cast<std::uint8_t>(number);
      else
        std::memcpy(raster.row(y) + 2 * i, &number, 2);
    }
  }
  return raster;
}

}  // namespace

TEST_GROUP(ImageFiles){};

TEST(ImageFiles, OfGreyHaveTheNumbersThatOtherProgramsWrote) {
  check_files(kGrey,
              {"grey8.png", "grey8_alpha.png", "grey8_raw.tif", "grey8_tiff_lzw.tif", "grey8_tiles.tif"});
  check_files(kWide, {"grey16.png", "grey16_interlaced.png", "grey16_raw.tif", "grey16_packbits.tif",
                      "grey16_tiff_lzw.tif", "grey16_big_endian.tif", "grey16_big_endian_lzw.tif",
                      "grey16_tiles.tif"});
}

TEST(ImageFiles, OfColoursHaveTheNumbersThatOtherProgramsWroteAndLeaveAlphaOut) {
  check_files(kColour, {"colour8.png", "colour8_alpha.png", "colour8_interlaced.png", "colour8_raw.tif",
                        "colour8_tiff_adobe_deflate.tif", "colour8_tiles.tif", "colour8_planes.tif",
                        "colour8_alpha.tif"});
  check_files(kWideColour, {"colour16.png", "colour16_lzw.tif", "colour16_planes.tif"});
}

TEST(ImageFiles, OfFewerBitsSpanTheWholeRangeAndThoseOfACamerasBitsStay) {
  check_files(kBlack, {"black.png", "black_group4.tif"});
  const Expected sixteenths{1, 8, [](int x, int y, int) { return 17 * (grey(x, y) >> 4); }};
  check_files(sixteenths, {"grey4.png", "grey4.tif"});
  check("12", read("grey12_packed.tif"), {1, 16, [](int x, int y, int) { return wide(x, y) >> 4; }});
  check("10", read("grey10_packed.tif"), {1, 16, [](int x, int y, int) { return wide(x, y) >> 6; }});
}

TEST(ImageFiles, OfPalettesHaveTheirColours) {
  for (const char* name : {"palette.png", "palette.tif"}) check_same(name, "palette_shown.png");
}

TEST(ImageFiles, OfWhichZeroIsWhiteAreBrightWhereThePictureIs) {
  constexpr int kMeaning = 262;
  const Expected negative{1, 8, [](int x, int y, int) { return 255 - grey(x, y); }};
  for (const char* name : {"grey8_tiff_lzw.tif", "grey8_raw.tif"})
    check(name, *decode_tiff(with_tag(name, kMeaning, 0)), negative);
  check("16 bits", *decode_tiff(with_tag("grey16_tiff_lzw.tif", kMeaning, 0)),
        {1, 16, [](int x, int y, int) { return 65535 - wide(x, y); }});
}

TEST(ImageFiles, OfJpegAreWhatAnotherProgramDecodes) {
  check_same("colour.jpg", "colour_shown.png");
  check_same("colour_444_progressive.jpg", "colour_444_progressive_shown.png");
  check_same("grey.jpg", "grey_shown.png");
  check_same("colour_turned.jpg", "colour_shown.png");
  check_same("colour8_jpeg.tif", "colour8_jpeg_shown.png");
  // Inks without black are what light lacks; JPEG at quality 90 keeps them to some ten numbers.
  const Raster inks = read("inks.jpg");
  LONGS_EQUAL(3, inks.channels());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      CHECK(std::abs(5 * x - number_at(inks, x, y, 0)) <= 12);
      CHECK(std::abs(9 * y - number_at(inks, x, y, 1)) <= 12);
    }
  }
}

TEST(ImageFiles, OfTiffAreTurnedAsTheirTagSays) {
  // Where the number shown at (x, y) was stored, by TIFF 6.0's table.
  const auto w = [](int x) { return kWidth - 1 - x; };
  const auto h = [](int y) { return kHeight - 1 - y; };
  const std::vector<Number> numbers{
      [&](int x, int y, int) { return wide(w(x), y); }, [&](int x, int y, int) { return wide(w(x), h(y)); },
      [&](int x, int y, int) { return wide(x, h(y)); }, [&](int x, int y, int) { return wide(y, x); },
      [&](int x, int y, int) { return wide(y, h(x)); }, [&](int x, int y, int) { return wide(w(y), h(x)); },
      [&](int x, int y, int) { return wide(w(y), x); }};
  for (int orientation = 2; orientation <= 8; ++orientation) {
    const auto turned = decode_tiff(with_tag("turned.tif", 274, orientation));
    check("turned", *turned, {1, 16, numbers[static_cast<std::size_t>(orientation - 2)]}, orientation >= 5);
  }
  check("turned6_colour.tif", read("turned6_colour.tif"),
        {3, 8, [&](int x, int y, int c) { return colour(y, h(x), c); }}, true);
  const Raster palette = read("palette_shown.png");
  check("turned8_palette.tif", read("turned8_palette.tif"),
        {3, 8, [&](int x, int y, int c) { return number_at(palette, w(y), x, c); }}, true);
}

TEST(ImageFiles, OfAMosaicHaveTheSensorsNumbers) {
  const Raster mosaic = read("mosaic.tif");
  check("mosaic.tif", mosaic, kWide);
  CHECK(mosaic.mosaic == Mosaic({{Mosaic::kGreen, Mosaic::kRed, Mosaic::kBlue, Mosaic::kGreen}, 128, 65535}));
}

TEST(ImageFiles, OfPngAndJpegAreNotTurnedButTellHowTheCameraWasHeld) {
  const Raster png = read("grey8_turned.png");
  check("grey8_turned.png", png, kGrey);
  LONGS_EQUAL(6, png.orientation);
  LONGS_EQUAL(8, read("colour_turned.jpg").orientation);
  for (const char* name : {"grey8.png", "colour.jpg", "turned6_colour.tif"}) LONGS_EQUAL(1, read(name).orientation);
}

TEST(ImageFiles, ComeBackAsTheyWereWrittenInEachFormatAndDepth) {
  for (const Expected& expected : {kGrey, kWide, kColour, kWideColour}) {
    const Raster raster = picture(expected);
    const auto png = encode_png(raster.pixels());
    check("png", *decode_png(*png), expected);
    for (const TiffOptions& options :
         {TiffOptions{}, TiffOptions{.rows_per_strip = 4}, TiffOptions{.lzw = true},
          TiffOptions{.lzw = true, .rows_per_strip = 5}})
      check("tiff", *decode_tiff(*encode_tiff(raster.pixels(), options)), expected);
  }
}

TEST(ImageFiles, AreWrittenFromRowsWithGaps) {
  const Raster raster = picture(kGrey);
  Pixels left = raster.pixels();
  left.width = 20;
  for (const auto& back : {decode_png(*encode_png(left)), decode_tiff(*encode_tiff(left))}) {
    LONGS_EQUAL(20, back->width());
    LONGS_EQUAL(grey(19, 20), number_at(*back, 19, 20, 0));
  }
}

TEST(ImageFiles, OfJpegAreAlmostAsTheyWereWritten) {
  const Expected smooth{3, 8, [](int x, int y, int c) { return c == 0 ? 5 * x : c == 1 ? 9 * y : 100; }};
  const auto back = decode_jpeg(*encode_jpeg(picture(smooth).pixels(), 95));
  CHECK(back.has_value());
  // Steps of quality 95 are up to 6 numbers, of colours at half the resolution twice the gradient of 9 besides.
  for (int y = 1; y < kHeight - 1; ++y)
    for (int x = 1; x < kWidth - 1; ++x)
      for (int c = 0; c < 3; ++c) CHECK(std::abs(smooth.number(x, y, c) - number_at(*back, x, y, c)) <= 24);
}

TEST(ImageFiles, OfNothingCannotBeWritten) {
  CHECK_FALSE(encode_png({}).has_value());
  CHECK_FALSE(encode_tiff({}).has_value());
  CHECK_FALSE(encode_jpeg(picture(kWide).pixels()).has_value());  // JPEG has 8 bits
}
