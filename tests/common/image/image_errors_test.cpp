// Bad files end in one line, whatever is bad, and take no more memory than their pixels.
#include <cstdint>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"
#include "tests/common/image/reference_files.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::image;
using strobe::testing::reference;
using strobe::testing::reference_bytes;
using Octets = std::vector<std::uint8_t>;

std::vector<std::string> all_files() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(reference("")))
    names.push_back(entry.path().filename().string());
  return names;
}

std::string complaint(const Octets& bytes) {
  return strobe::testing::error_of(decode(bytes));
}

void check_line(const std::string& name, const std::string& message) {
  CHECK_TEXT(!message.empty() && message.find('\n') == std::string::npos, (name + ": " + message).c_str());
}

void put(Octets& bytes, std::size_t at, std::uint32_t number) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(number >> (24 - 8 * i));
}

}  // namespace

TEST_GROUP(ImageErrors){};

// Some files end with bytes that no pixel needs, as a TIFF with a palette that was replaced.
TEST(ImageErrors, OfFilesCutShortAtEveryByteAreOneLineUnlessAllPixelsAreThere) {
  for (const std::string& name : all_files()) {
    const Octets whole = reference_bytes(name);
    const auto picture = decode(whole);
    if (!picture) continue;  // of floating-point numbers
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto part =
          decode(Octets(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      if (!part)
        check_line(name + " of " + std::to_string(size), part.error().message);
      else
        MEMCMP_EQUAL_TEXT(picture->row(0), part->row(0), picture->size_bytes(),
                          (name + " of " + std::to_string(size)).c_str());
    }
  }
}

TEST(ImageErrors, OfABytesBitsChangedAreOneLineIfAny) {
  for (const std::string& name : all_files()) {
    Octets bytes = reference_bytes(name);
    constexpr std::size_t kStep = 3;  // the fuzzer tries the others
    for (std::size_t at = 0; at < bytes.size(); at += kStep) {
      std::uint8_t& byte = bytes[at];
      byte = static_cast<std::uint8_t>(byte ^ 0x81);
      if (const std::string message = complaint(bytes); !message.empty()) check_line(name, message);
      byte = static_cast<std::uint8_t>(byte ^ 0x81);
    }
  }
}

TEST(ImageErrors, SayWhatIsNotRead) {
  STRCMP_CONTAINS("floating-point numbers of 32 bits",
                  complaint(reference_bytes("floats.tif")).c_str());
  STRCMP_CONTAINS("the file is empty", complaint({}).c_str());
  STRCMP_CONTAINS("not a TIFF, PNG or JPEG file", complaint(Octets(100, 'x')).c_str());
}

TEST(ImageErrors, OfPixelsThatCannotBeThereComeBeforeMemoryIsTaken) {
  // 10,000 x 10,000 pixels in a file of a kilobyte: an allocation of these would fail under the tests' limit.
  Octets png = reference_bytes("colour8.png");
  put(png, 16, 10'000);
  put(png, 20, 10'000);
  check_line("png", complaint(png));
  Octets huge = reference_bytes("colour8.png");
  put(huge, 16, 0x7FFFFFFF);
  check_line("png", complaint(huge));
  Octets jpeg = reference_bytes("grey.jpg");
  for (std::size_t i = 0; i + 8 < jpeg.size(); ++i) {
    if (jpeg[i] != 0xFF || jpeg[i + 1] != 0xC0) continue;
    jpeg[i + 5] = jpeg[i + 7] = 0x27;
    break;
  }
  STRCMP_CONTAINS("its pixels are not all there", complaint(jpeg).c_str());
}

TEST(ImageErrors, OfJpegsThatADecoderWouldMendByGuessing) {
  Octets bytes = reference_bytes("grey.jpg");
  // In the middle of the last quarter, which is of the picture: a marker that ends it.
  const std::size_t at = bytes.size() - bytes.size() / 8;
  bytes[at] = 0xFF;
  bytes[at + 1] = 0xD9;
  STRCMP_CONTAINS("the JPEG file is damaged", complaint(bytes).c_str());
}
