#include "host/digitize/image/photograph.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/support/error_of.hpp"
#include "tests/support/pictures.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::digitize;

namespace {

using Bytes = std::vector<unsigned char>;

using strobe::testing::encoded_picture;

/// 20 rows of 30: the number at (column, row) is step·(30·row + column), cut off at the top.
cv::Mat ramp(int depth, int step) {
  cv::Mat pixels(20, 30, depth);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const int value = step * (30 * y + x);
      if (depth == CV_8U)
        pixels.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(value);
      else
        pixels.at<unsigned short>(y, x) = cv::saturate_cast<unsigned short>(value);
    }
  return pixels;
}

/// A picture without structure near the top of its numbers, with a heap of 400 pixels from `from` to `to`.
cv::Mat with_heap(int depth, int from, int to) {
  cv::Mat pixels(100, 100, depth);
  for (int i = 0; i < 10000; ++i) {
    const int value = i < 9600 ? i % (from / 2) : from + i % (to - from + 1);
    if (depth == CV_8U)
      pixels.at<unsigned char>(i / 100, i % 100) = static_cast<unsigned char>(value);
    else
      pixels.at<unsigned short>(i / 100, i % 100) = static_cast<unsigned short>(value);
  }
  return pixels;
}

std::string complaint(const Bytes& bytes) {
  return strobe::testing::error_of(decode_photograph(bytes, "shot.tif"));
}

}  // namespace

TEST_GROUP(Photograph){void check_complaint(const Bytes& bytes, const std::string& part){
    const std::string message = complaint(bytes);
CHECK_TRUE(message.starts_with("shot.tif: "));
CHECK_EQUAL(std::string::npos, message.find('\n'));
if (message.find(part) == std::string::npos) FAIL(("\"" + part + "\" is not in: " + message).c_str());
}
}
;

TEST(Photograph, LightIsProportionalToTheFilesNumbersWhateverTheFormat) {
  for (const int depth : {CV_8U, CV_16U}) {
    const double top = depth == CV_8U ? 255.0 : 65535.0;
    const cv::Mat pixels = ramp(depth, depth == CV_8U ? 1 : 101);
    for (const std::string extension : {".tif", ".png"}) {
      const auto photograph = decode_photograph(encoded_picture(pixels, extension), "a");
      CHECK_TRUE(photograph.has_value());
      CHECK_EQUAL(depth == CV_8U ? 8 : 16, photograph->bits);
      CHECK_EQUAL(30, photograph->width());
      cv::Mat expected;
      pixels.convertTo(expected, CV_32F, 1.0 / top);
      // Single precision's rounding of numbers up to one.
      CHECK_TRUE(cv::norm(photograph->intensity, expected, cv::NORM_INF) <= 1.2e-7);
    }
  }
}

TEST(Photograph, APixelAtTheTopOfTheFileCountsAsSaturated) {
  for (const int depth : {CV_8U, CV_16U}) {
    const cv::Mat pixels(20, 20, depth, cv::Scalar(depth == CV_8U ? 255 : 65535));
    const auto photograph = decode_photograph(encoded_picture(pixels, ".png"), "a");
    CHECK_TRUE(photograph.has_value());
    CHECK_TRUE(photograph->intensity.at<float>(3, 3) >= photograph->saturation);
  }
}

TEST(Photograph, EnlargedHasItsEdgesWhereTheyWereAndStaysSaturated) {
  strobe::digitize::Photograph photograph;
  photograph.saturation = 0.9F;
  photograph.intensity = cv::Mat(20, 20, CV_32FC1, cv::Scalar(0.1));
  photograph.intensity.colRange(12, 16).setTo(0.85);
  photograph.intensity.colRange(16, 20).setTo(0.95);
  const auto larger = enlarged(photograph, 2);
  LONGS_EQUAL(40, larger.width());
  LONGS_EQUAL(40, larger.height());
  // Half-way between the columns 11 and 12, that is between 23 and 24, which are as far off it either way.
  const auto* row = larger.intensity.ptr<float>(20);
  DOUBLES_EQUAL(0.1 + 0.85, row[23] + row[24], 1e-6);
  // Cubics between .85 and .1 swing over both.
  for (int column = 0; column < 32; ++column) CHECK_TRUE(row[column] >= 0.0F && row[column] < larger.saturation);
  for (int column = 32; column < 40; ++column) CHECK_TRUE(row[column] >= larger.saturation);
}

TEST(Photograph, ColoursBecomeTheirLuminance) {
  const cv::Mat pixels(16, 16, CV_8UC3, cv::Scalar(40, 80, 160));  // blue, green, red
  const auto photograph = decode_photograph(encoded_picture(pixels, ".png"), "a");
  CHECK_TRUE(photograph.has_value());
  // ITU-R BT.601, to a whole number of the file.
  DOUBLES_EQUAL(0.114 * 40 + 0.587 * 80 + 0.299 * 160, 255.0 * photograph->intensity.at<float>(5, 5), 0.51);
}

TEST(Photograph, CountsAsSaturatedWhereOneColourIsFull) {
  // Green is full in one corner: the sum of light there is not known, though red and blue are.
  cv::Mat pixels(40, 60, CV_8UC3, cv::Scalar(40, 90, 60));
  pixels(cv::Rect(0, 0, 20, 20)).setTo(cv::Scalar(40, 255, 160));
  const auto photograph = decode_photograph(encoded_picture(pixels, ".png"), "colours.png");
  CHECK_TRUE(photograph.has_value());
  CHECK_TRUE(photograph->intensity.at<float>(10, 10) >= photograph->saturation);
  const float elsewhere = photograph->intensity.at<float>(30, 40);
  CHECK_TRUE(elsewhere > 40.0F / 255.0F && elsewhere < 90.0F / 255.0F);
}

TEST(Photograph, OfFewerBitsIsNoBrighterWhereOneColourIsFull) {
  // 12 bits in a file of 16.
  cv::Mat pixels(40, 60, CV_16UC3, cv::Scalar(640, 1440, 960));
  pixels(cv::Rect(0, 0, 20, 20)).setTo(cv::Scalar(640, 4095, 2560));
  const auto photograph = decode_photograph(encoded_picture(pixels, ".png"), "colours.png");
  CHECK_TRUE(photograph.has_value());
  double brightest = 0.0;
  cv::minMaxLoc(photograph->intensity, nullptr, &brightest);
  DOUBLES_EQUAL(4095.0 / 65535.0, brightest, 1e-6);
  CHECK_TRUE(photograph->intensity.at<float>(10, 10) >= photograph->saturation);
  CHECK_TRUE(photograph->intensity.at<float>(30, 40) < photograph->saturation);
}

TEST(Photograph, TellsHowManyBitsItsNumbersFill) {
  const auto bits_of = [](const cv::Mat& pixels, const strobe::image::TiffOptions& options = {}) {
    return decode_photograph(encoded_picture(pixels, ".tif", options), "a")->bits;
  };
  CHECK_EQUAL(8, bits_of(ramp(CV_8U, 3)));
  CHECK_EQUAL(16, bits_of(ramp(CV_16U, 1)));
  // 12 bits at the top of 16; 8 spread over 16.
  CHECK_EQUAL(12, bits_of(ramp(CV_16U, 16)));
  CHECK_EQUAL(8, bits_of(ramp(CV_16U, 257)));
  strobe::image::Mosaic mosaic;
  mosaic.black = 512;
  mosaic.white = 16 * 4095;
  CHECK_EQUAL(12, bits_of(ramp(CV_16U, 16), {.mosaic = mosaic}));
  mosaic.white = 16383;
  CHECK_EQUAL(14, bits_of(ramp(CV_16U, 3), {.mosaic = mosaic}));
}

TEST(Photograph, AFileThatEndsTooEarlyIsNone) {
  for (const std::string extension : {".tif", ".png", ".jpg"}) {
    const Bytes whole = encoded_picture(ramp(CV_8U, 1), extension);
    CHECK_TRUE(decode_photograph(whole, "a").has_value());
    for (std::size_t length = 0; length < whole.size(); length += 1 + length / 8)
      check_complaint(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)), "");
  }
}

TEST(Photograph, WhatIsNoPictureIsNamed) {
  check_complaint({}, "the file is empty");
  check_complaint(Bytes(100, 'x'), "not a TIFF, PNG or JPEG file");
  check_complaint(encoded_picture(cv::Mat::zeros(15, 40, CV_8U), ".png"), "40 x 15 pixels are too few");
}

TEST(Photograph, AHeaderOfBillionsOfPixelsIsRefusedBeforeTheyAreAllocated) {
  Bytes jpeg = encoded_picture(ramp(CV_8U, 1), ".jpg");
  const std::array frame{0xFF, 0xC0};
  const auto at = std::ranges::search(jpeg, frame).begin() - jpeg.begin();
  for (const int high : {5, 7}) jpeg[static_cast<std::size_t>(at + high)] = 0xFF;  // rows and columns, 65280 or more
  check_complaint(jpeg, "more than the 120 million");
}

TEST(Photograph, PathsThatAreNoPlainFileAreNamed) {
  for (const std::string path : {"/", "/dev/null", "/no/such/photograph.tif"}) {
    const auto photograph = load_photograph(path);
    CHECK_FALSE(photograph.has_value());
    CHECK_TRUE(photograph.error().message.starts_with(path + ": "));
  }
}

TEST_GROUP(Saturation){};

TEST(Saturation, IsTheTopOfASensorOfFewerBitsThanTheFile) {
  // Found to a 256th of the sensor's range.
  DOUBLES_EQUAL(4095.0, saturation_level(with_heap(CV_16U, 4095, 4095)), 16.0);
  DOUBLES_EQUAL(65520.0, saturation_level(with_heap(CV_16U, 65520, 65520)), 256.0);
  DOUBLES_EQUAL(1023.0, saturation_level(with_heap(CV_16U, 1023, 1023)), 4.0);
}

TEST(Saturation, IsFoundWhereCompressionSpreadsIt) {
  const double level = saturation_level(with_heap(CV_8U, 247, 252));
  CHECK_TRUE(level <= 247.0 && level >= 244.0);
}

TEST(Saturation, IsTheFilesTopWhereNothingIsHeapedUp) {
  DOUBLES_EQUAL(255.0, saturation_level(ramp(CV_8U, 1).rowRange(0, 8)), 0.0);
  DOUBLES_EQUAL(65535.0, saturation_level(ramp(CV_16U, 5)), 0.0);
  // An evenly lit object, but far from what eight bits hold.
  DOUBLES_EQUAL(255.0, saturation_level(with_heap(CV_8U, 180, 180)), 0.0);
}

TEST(Photograph, OfPlainTiffIsReadAsThePackedOne) {
  for (const int depth : {CV_8U, CV_16U}) {
    const cv::Mat pixels = ramp(depth, depth == CV_8U ? 1 : 97);
    // 7 rows a strip, so that there are several.
    const Bytes plain = encoded_picture(pixels, ".tif", {.rows_per_strip = 7});
    const Bytes packed = encoded_picture(pixels, ".tif", {.lzw = true});
    const auto a = decode_photograph(plain, "plain"), b = decode_photograph(packed, "packed");
    CHECK_TRUE(a.has_value() && b.has_value());
    DOUBLES_EQUAL(0.0, cv::norm(a->intensity, b->intensity, cv::NORM_INF), 0.0);
    DOUBLES_EQUAL(a->saturation, b->saturation, 0.0);
  }
}
