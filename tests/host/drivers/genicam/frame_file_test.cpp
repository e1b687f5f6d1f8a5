#include "host/drivers/genicam/frame_file.hpp"

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/image/image_files.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::genicam;

namespace {

constexpr std::uint32_t kMono12 = 0x01100005, kBayerRg12 = 0x01100011, kMono8 = 0x01080001,
                        kBayerRg8 = 0x01080009, kMono12p = 0x010C0047;

image::Raster decoded(const Frame& frame) {
  const auto tiff = tiff_of(frame);
  CHECK_TEXT(tiff.has_value(), tiff ? "" : tiff.error().message.c_str());
  std::vector<std::uint8_t> bytes = tiff->start;
  bytes.insert(bytes.end(), tiff->pixels.begin(), tiff->pixels.end());
  auto raster = image::decode_tiff(bytes);
  CHECK_TEXT(raster.has_value(), raster ? "" : raster.error().message.c_str());
  return std::move(*raster);
}

int number_at(const image::Raster& raster, int x, int y) {
  return raster.bits() == 8 ? raster.row(y)[x] : reinterpret_cast<const std::uint16_t*>(raster.row(y))[x];
}

}  // namespace

TEST_GROUP(GenicamFrameFile) { const testing::TemporaryFolder folder; };

TEST(GenicamFrameFile, NumbersOfTwelveBitsAreNotScaledAndPaddingIsLeftOut) {
  // Two rows of two, four bytes of padding after each.
  const std::vector<std::uint8_t> bytes{0xFF, 0x0F, 1, 0, 9, 9, 9, 9, 2, 0, 3, 1, 9, 9, 9, 9};
  const image::Raster raster = decoded({kMono12, 2, 2, 4, bytes});
  LONGS_EQUAL(16, raster.bits());
  LONGS_EQUAL(4095, number_at(raster, 0, 0));
  LONGS_EQUAL(1, number_at(raster, 1, 0));
  LONGS_EQUAL(2, number_at(raster, 0, 1));
  LONGS_EQUAL(0x103, number_at(raster, 1, 1));
  CHECK_FALSE(raster.mosaic.has_value());
}

TEST(GenicamFrameFile, ColourSensorsPixelsBecomeAMosaicThatSaysWhatWhiteIs) {
  const std::vector<std::uint8_t> words{1, 0, 2, 0, 3, 0, 4, 0}, bytes{1, 2, 3, 255};
  const image::Raster twelve = decoded({kBayerRg12, 2, 2, 0, words});
  CHECK_TRUE(twelve.mosaic.has_value());
  LONGS_EQUAL(4095, twelve.mosaic->white);
  LONGS_EQUAL(image::Mosaic::kRed, twelve.mosaic->colour(0, 0));
  LONGS_EQUAL(4, number_at(twelve, 1, 1));
  const image::Raster eight = decoded({kBayerRg8, 2, 2, 0, bytes});
  LONGS_EQUAL(255, eight.mosaic->white);
  LONGS_EQUAL(255, number_at(eight, 1, 1));
}

TEST(GenicamFrameFile, GreyOfEightBitsStaysSoAndPackedNumbersAreUnpacked) {
  const std::vector<std::uint8_t> bytes{1, 2, 3, 255}, packed{0xCA, 0xDB, 0xFE};
  LONGS_EQUAL(8, decoded({kMono8, 2, 2, 0, bytes}).bits());
  LONGS_EQUAL(0xFED, number_at(decoded({kMono12p, 2, 1, 0, packed}), 1, 0));
}

TEST(GenicamFrameFile, WhatAFrameSaysOfItselfIsNotBelieved) {
  const std::vector<std::uint8_t> bytes(16);
  const auto refusal = [](const Frame& frame) { return tiff_of(frame).error().message; };
  CHECK_EQUAL("16 bytes are too few for 3 x 3 pixels of Mono12", refusal({kMono12, 3, 3, 0, bytes}));
  CHECK_EQUAL("16 bytes are too few for 2 x 2 pixels of Mono12", refusal({kMono12, 2, 2, 1 << 30, bytes}));
  CHECK_EQUAL("a frame of 2000000000 x 2000000000 pixels",
              refusal({kMono12, 2'000'000'000, 2'000'000'000, 0, bytes}));
  CHECK_EQUAL("a frame of -2 x 2 pixels", refusal({kMono12, -2, 2, 0, bytes}));
  CHECK_EQUAL("a frame of 0 x 2 pixels", refusal({kMono12, 0, 2, 0, bytes}));
  CHECK_EQUAL("a frame of 2 x 2 pixels", refusal({kMono12, 2, 2, -1, bytes}));
  CHECK_EQUAL("pixels of the format 0x2180014", refusal({0x02180014, 2, 2, 0, bytes}));
  CHECK_EQUAL("rows of 3 pixels of Mono12p do not end with a byte", refusal({kMono12p, 3, 1, 0, bytes}));
}

TEST(GenicamFrameFile, IsWholeUnderItsNameAndAsOldAsTheExposure) {
  const std::vector<std::uint8_t> pixels{'b'};
  const TiffFile tiff{.start = {'a'}, .pixels = pixels, .unpacked = {}};
  const WallTime ended{Duration{1'700'000'000'123'456'789}};
  CHECK_EQUAL("frame.tif", *put_file(folder.path(), "frame", tiff, ended));
  CHECK_EQUAL("frame-2.tif", *put_file(folder.path(), "frame", tiff, ended));
  CHECK_EQUAL("ab", testing::read_text(folder / "frame.tif"));
  struct stat status {};
  LONGS_EQUAL(0, stat((folder / "frame-2.tif").c_str(), &status));
  CHECK_EQUAL(1'700'000'000, status.st_mtim.tv_sec);
  CHECK_EQUAL(123'456'789, status.st_mtim.tv_nsec);
  LONGS_EQUAL(2, std::distance(std::filesystem::directory_iterator(folder.path()), {}));
}

TEST(GenicamFrameFile, FolderThatIsGoneIsNamed) {
  const auto put = put_file(folder / "none", "frame", TiffFile{}, WallTime{});
  CHECK_EQUAL((folder / "none/frame.tif").string() + ": No such file or directory", put.error().message);
}
