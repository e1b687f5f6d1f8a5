// A colour sensor's mosaic in a TIFF file: written here tag by tag after TIFF 6.0 and TIFF/EP, or by encode_tiff.
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"
#include "tests/support/error_of.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::image;
using Octets = std::vector<std::uint8_t>;

constexpr std::uint16_t kWidth = 6, kHeight = 4;
int number(int x, int y) { return 1000 * y + 37 * x; }

void put_short(Octets& bytes, std::uint32_t number) {
  bytes.push_back(static_cast<std::uint8_t>(number & 255U));
  bytes.push_back(static_cast<std::uint8_t>(number >> 8 & 255U));
}

void put_long(Octets& bytes, std::uint32_t number) {
  put_short(bytes, number & 65535U);
  put_short(bytes, number >> 16);
}

struct Tag {
  std::uint16_t type, count;  ///< 1 BYTE, 3 SHORT, 4 LONG
  std::uint32_t value;        ///< the four bytes, the lowest first
};
using Tags = std::map<std::uint16_t, Tag>;

Tags mosaic_tags() {
  return {{256, {3, 1, kWidth}}, {257, {3, 1, kHeight}},    {258, {3, 1, 16}},         {259, {3, 1, 1}},
          {262, {3, 1, 32803}},  {273, {4, 1, 8}},          {277, {3, 1, 1}},          {278, {3, 1, kHeight}},
          {279, {4, 1, 2 * kWidth * kHeight}},              {33421, {3, 2, 2U << 16 | 2U}},
          {33422, {1, 4, 1U << 24 | 2U << 16 | 0U << 8 | 1U}},  // green, red; blue, green
          {50714, {3, 1, 128}},  {50717, {3, 1, 4000}}};
}

Octets file(const Tags& tags) {
  Octets bytes{'I', 'I', 42, 0};
  put_long(bytes, 8 + 2 * kWidth * kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) put_short(bytes, static_cast<std::uint32_t>(number(x, y)));
  put_short(bytes, static_cast<std::uint32_t>(tags.size()));
  for (const auto& [name, tag] : tags) {
    put_short(bytes, name);
    put_short(bytes, tag.type);
    put_long(bytes, tag.count);
    put_long(bytes, tag.value);
  }
  put_long(bytes, 0);
  return bytes;
}

int number_at(const Raster& raster, int x, int y) {
  std::uint16_t value = 0;
  std::memcpy(&value, raster.row(y) + 2 * x, 2);
  return value;
}

void check_numbers(const Raster& raster) {
  LONGS_EQUAL(kWidth, raster.width());
  LONGS_EQUAL(kHeight, raster.height());
  LONGS_EQUAL(1, raster.channels());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) LONGS_EQUAL(number(x, y), number_at(raster, x, y));
}

Raster picture() {
  Raster raster(kWidth, kHeight, 1, 16);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto value = static_cast<std::uint16_t>(number(x, y));
      std::memcpy(raster.row(y) + 2 * x, &value, 2);
    }
  return raster;
}

}  // namespace

TEST_GROUP(MosaicTiff){};

TEST(MosaicTiff, IsReadWithItsColoursAndLevels) {
  const auto raster = decode(file(mosaic_tags()));
  CHECK_TEXT(raster.has_value(), strobe::testing::error_of(raster).c_str());
  check_numbers(*raster);
  CHECK(raster->mosaic.has_value());
  LONGS_EQUAL(128, raster->mosaic->black);
  LONGS_EQUAL(4000, raster->mosaic->white);
  const int colours[] = {Mosaic::kGreen, Mosaic::kRed, Mosaic::kBlue, Mosaic::kGreen};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      LONGS_EQUAL(colours[2 * (y % 2) + x % 2], raster->mosaic->colour(x, y));
}

// A turned mosaic would have other colours; a fixed camera's calibration is of the pixels as they are stored.
TEST(MosaicTiff, IsNotTurned) {
  Tags tags = mosaic_tags();
  tags[274] = {3, 1, 6};
  const auto raster = decode(file(tags));
  check_numbers(*raster);
  LONGS_EQUAL(6, raster->orientation);
}

TEST(MosaicTiff, WithoutWhatItNeedsIsACamerasRawFile) {
  const std::map<std::uint16_t, Tag> wrong{
      {258, {3, 1, 14}},                 // bits
      {259, {3, 1, 7}},                  // lossless JPEG
      {33421, {3, 2, 6U << 16 | 6U}},    // X-Trans
      {33422, {1, 4, 1U << 8}},          // red, green; red, red
      {50714, {3, 1, 4000}},             // no number lies between black and white
      {50717, {4, 1, 70000}},
      {50706, {1, 4, 0x0401U}},          // a DNG, which has more to tell
  };
  CHECK(!is_camera_raw(file(mosaic_tags())));
  for (const auto& [name, tag] : wrong) {
    Tags tags = mosaic_tags();
    tags[name] = tag;
    STRCMP_CONTAINS("a camera's RAW file", strobe::testing::error_of(decode(file(tags))).c_str());
    CHECK(is_camera_raw(file(tags)));
  }
  for (const int name : {33421, 33422, 50714, 50717}) {
    Tags tags = mosaic_tags();
    tags.erase(static_cast<std::uint16_t>(name));
    STRCMP_CONTAINS("a camera's RAW file", strobe::testing::error_of(decode(file(tags))).c_str());
  }
}

TEST(MosaicTiff, ComesBackAsItWasWritten) {
  const Raster raster = picture();
  for (const auto& colours : {std::array<std::uint8_t, 4>{0, 1, 1, 2}, {2, 1, 1, 0}, {1, 0, 2, 1}, {1, 2, 0, 1}}) {
    const Mosaic mosaic{colours, 64, 16383};
    const auto back = decode_tiff(*encode_tiff(raster.pixels(), {.mosaic = mosaic}));
    check_numbers(*back);
    CHECK(back->mosaic == mosaic);
  }
}

TEST(MosaicTiff, OfOtherPixelsOrImpossibleColoursIsNotWritten) {
  const Raster raster = picture();
  const auto refused = [](const Pixels& pixels, const TiffOptions& options) {
    CHECK_FALSE(encode_tiff(pixels, options).has_value());
  };
  refused(raster.pixels(), {.mosaic = Mosaic{{0, 1, 2, 1}, 0, 4095}});
  refused(raster.pixels(), {.mosaic = Mosaic{{0, 1, 1, 2}, 100, 100}});
  refused(raster.pixels(), {.lzw = true, .mosaic = Mosaic{}});
  refused(Raster(4, 4, 1, 8).pixels(), {.mosaic = Mosaic{}});
  refused(Raster(4, 4, 3, 16).pixels(), {.mosaic = Mosaic{}});
}

TEST(MosaicTiff, IsToldFromCamerasOwnFormatsByTheirFirstBytes) {
  const auto padded = [](std::string text) {
    text.resize(100, 'x');
    return Octets(text.begin(), text.end());
  };
  const std::string kZero(1, '\0');
  for (const std::string& mark : {"II\x1a" + kZero + kZero + kZero + "HEAPCCDR", "II*" + kZero + "\x10" + kZero + kZero + kZero + "CR\2" + kZero,
                                  kZero + kZero + kZero + "\x18" "ftypcrx ", std::string("FUJIFILMCCD-RAW 0201"),
                                  std::string("IIRO"), "IIU" + kZero, std::string("FOVb"), kZero + "MRM"})
    CHECK_TEXT(is_camera_raw(padded(mark)), mark.c_str());
  for (const std::string& mark : {std::string("\xFF\xD8\xFF"), std::string("FUJIFILM"), "II*" + kZero, std::string()})
    CHECK_FALSE(is_camera_raw(padded(mark)));
}
