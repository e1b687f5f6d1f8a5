// Rows as the standards draw them: PFNC 2.4 (Mono12p: figure of unpacked and packed pixels), GigE Vision 1.2
// section 23 (Mono12Packed, Mono10Packed).
#include "host/drivers/genicam/pixel_format.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::genicam;

namespace {

std::vector<std::uint16_t> unpacked(std::string_view name, const std::vector<std::uint8_t>& row,
                                    std::size_t width) {
  const PixelFormat* format = find_pixel_format(name);
  CHECK_TRUE(format != nullptr);
  CHECK_EQUAL(row.size(), *row_bytes(*format, static_cast<int>(width)));
  std::vector<std::uint16_t> numbers(width);
  unpack_row(*format, row, numbers);
  return numbers;
}

void check(const std::vector<std::uint16_t>& expected, const std::vector<std::uint16_t>& found) {
  CHECK_EQUAL(expected.size(), found.size());
  for (std::size_t i = 0; i < expected.size(); ++i) LONGS_EQUAL(expected[i], found[i]);
}

}  // namespace

TEST_GROUP(GenicamPixelFormat){};

TEST(GenicamPixelFormat, DenseNumbersFollowEachOtherFromTheLowestBit) {
  check({0xBCA, 0xFED}, unpacked("Mono12p", {0xCA, 0xDB, 0xFE}, 2));
  // Four of ten bits in five bytes: 0x3FF, 0, 0x155, 0x200.
  check({0x3FF, 0, 0x155, 0x200}, unpacked("BayerRG10p", {0xFF, 0x03, 0x50, 0x15, 0x80}, 4));
}

TEST(GenicamPixelFormat, PairedNumbersShareTheMiddleByte) {
  check({0xABC, 0xDEF}, unpacked("Mono12Packed", {0xAB, 0xFC, 0xDE}, 2));
  check({0x3FD, 0x002}, unpacked("Mono10Packed", {0xFF, 0x21, 0x00}, 2));
}

TEST(GenicamPixelFormat, BytesBecomeNumbersAsTheyAre) {
  check({0, 7, 255}, unpacked("BayerGB8", {0, 7, 255}, 3));
}

TEST(GenicamPixelFormat, TilesAreOfTheFirstTwoRows) {
  constexpr std::uint8_t kRed = 0, kGreen = 1, kBlue = 2;
  const std::array<std::uint8_t, 4> rggb{kRed, kGreen, kGreen, kBlue}, gbrg{kGreen, kBlue, kRed, kGreen};
  CHECK_TRUE(rggb == *find_pixel_format("BayerRG12")->mosaic());
  CHECK_TRUE(gbrg == *find_pixel_format("BayerGB16")->mosaic());
  CHECK_FALSE(find_pixel_format("Mono12")->mosaic().has_value());
}

TEST(GenicamPixelFormat, RowsThatEndWithinAByteAreNotUnderstood) {
  CHECK_FALSE(row_bytes(*find_pixel_format("Mono12p"), 3).has_value());
  CHECK_EQUAL(std::size_t{6}, *row_bytes(*find_pixel_format("Mono12"), 3));
}

TEST(GenicamPixelFormat, EachNameAndCodeIsThereOnce) {
  for (const PixelFormat& format : pixel_formats()) {
    POINTERS_EQUAL(&format, find_pixel_format(format.code));
    POINTERS_EQUAL(&format, find_pixel_format(format.name));
    CHECK_TRUE(format.bits_in_memory() >= format.bits);
  }
  POINTERS_EQUAL(nullptr, find_pixel_format("RGB8"));
}
