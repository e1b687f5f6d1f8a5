#include "sim/photograph/dng.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "sim/photograph/colours.hpp"

namespace strobe::sim {

namespace {

using Octets = std::vector<std::uint8_t>;

/// TIFF's types.
enum : std::uint16_t { kByte = 1, kText = 2, kShort = 3, kLong = 4, kRational = 5, kSigned = 10 };

void put(Octets& to, std::uint32_t number, int bytes) {
  for (int i = 0; i < bytes; ++i) to.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
}

struct Entry {
  std::uint16_t tag, type;
  std::uint32_t count;
  Octets value;
};

Entry bytes_of(std::uint16_t tag, std::initializer_list<std::uint8_t> numbers) {
  return {tag, kByte, static_cast<std::uint32_t>(numbers.size()), Octets(numbers)};
}

Entry numbers_of(std::uint16_t tag, std::uint16_t type, std::initializer_list<std::uint32_t> numbers) {
  Entry entry{tag, type, static_cast<std::uint32_t>(numbers.size()), {}};
  for (const std::uint32_t number : numbers) put(entry.value, number, type == kShort ? 2 : 4);
  return entry;
}

Entry text_of(std::uint16_t tag, const char* text) {
  const std::size_t size = std::strlen(text) + 1;
  return {tag, kText, static_cast<std::uint32_t>(size), Octets(text, text + size)};
}

template <typename Numbers>
Entry fractions_of(std::uint16_t tag, std::uint16_t type, const Numbers& numbers) {
  constexpr std::int32_t kParts = 10000;
  Entry entry{tag, type, static_cast<std::uint32_t>(numbers.size()), {}};
  for (const double number : numbers) {
    put(entry.value, static_cast<std::uint32_t>(std::lround(number * kParts)), 4);
    put(entry.value, kParts, 4);
  }
  return entry;
}

constexpr std::uint32_t kDataStart = 8;

/// In order of their tags.
std::vector<Entry> entries(const image::Pixels& pixels, const image::Mosaic& mosaic) {
  const auto width = static_cast<std::uint32_t>(pixels.width),
             height = static_cast<std::uint32_t>(pixels.height);
  constexpr std::uint32_t kMosaic = 32803, kDaylight = 21;
  // From XYZ to a sensor whose colours are sRGB's primaries with daylight's gains.
  constexpr std::array<double, 9> kMatrix{1.6205, -0.7686, -0.2493, -0.9693, 1.8760,
                                          0.0416, 0.0373,  -0.1367, 0.7083};
  const auto& c = mosaic.colours;
  return {numbers_of(254, kLong, {0}),
          numbers_of(256, kLong, {width}),
          numbers_of(257, kLong, {height}),
          numbers_of(258, kShort, {16}),
          numbers_of(259, kShort, {1}),
          numbers_of(262, kShort, {kMosaic}),
          text_of(271, "Strobe"),
          text_of(272, "Simulated camera"),
          numbers_of(273, kLong, {kDataStart}),
          numbers_of(274, kShort, {1}),
          numbers_of(277, kShort, {1}),
          numbers_of(278, kLong, {height}),
          numbers_of(279, kLong, {2 * width * height}),
          numbers_of(284, kShort, {1}),
          numbers_of(33421, kShort, {2, 2}),
          bytes_of(33422, {c[0], c[1], c[2], c[3]}),
          bytes_of(50706, {1, 4, 0, 0}),
          bytes_of(50707, {1, 1, 0, 0}),
          text_of(50708, "Strobe simulated camera"),
          numbers_of(50714, kLong, {static_cast<std::uint32_t>(mosaic.black)}),
          numbers_of(50717, kLong, {static_cast<std::uint32_t>(mosaic.white)}),
          fractions_of(50721, kSigned, kMatrix),
          fractions_of(50728, kRational, kNeutral),
          numbers_of(50778, kShort, {kDaylight})};
}

}  // namespace

Result<Octets> encode_dng(const image::Pixels& pixels, const image::Mosaic& mosaic) {
  constexpr int kMaxSide = 30000;  // offsets have 32 bits
  if (pixels.numbers == nullptr || pixels.bits != 16 || pixels.channels != 1 || pixels.width < 1 ||
      pixels.height < 1 || std::max(pixels.width, pixels.height) > kMaxSide || !mosaic.is_valid())
    return fail("cannot be encoded");
  const std::vector<Entry> all = entries(pixels, mosaic);
  const std::size_t row = 2 * static_cast<std::size_t>(pixels.width);
  const std::size_t directory = kDataStart + row * static_cast<std::size_t>(pixels.height);
  Octets file{'I', 'I', 42, 0};
  file.reserve(directory + 4096);
  put(file, static_cast<std::uint32_t>(directory), 4);
  for (int y = 0; y < pixels.height; ++y) file.insert(file.end(), pixels.row(y), pixels.row(y) + row);
  put(file, static_cast<std::uint32_t>(all.size()), 2);
  std::size_t beyond = directory + 2 + 12 * all.size() + 4;
  Octets values;
  for (const Entry& entry : all) {
    put(file, entry.tag, 2);
    put(file, entry.type, 2);
    put(file, entry.count, 4);
    Octets inside = entry.value;
    if (inside.size() > 4) {
      inside.clear();
      put(inside, static_cast<std::uint32_t>(beyond + values.size()), 4);
      values.insert(values.end(), entry.value.begin(), entry.value.end());
      if (values.size() % 2 != 0) values.push_back(0);
    }
    inside.resize(4);
    file.insert(file.end(), inside.begin(), inside.end());
  }
  put(file, 0, 4);
  file.insert(file.end(), values.begin(), values.end());
  return file;
}

}  // namespace strobe::sim
