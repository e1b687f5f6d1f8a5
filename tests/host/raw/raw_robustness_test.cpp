// A damaged or hostile RAW file ends in a mosaic or in one line with status 1, never in a signal.
#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "tests/host/raw/dng_pictures.hpp"

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(RawRobustness) {
  TemporaryFolder folder;

  void check_end(const std::string& what, const std::string& file) {
    write_text(folder / "a.dng", file);
    const auto run = run_program({raw_program(), folder / "a.dng", folder / "a.tif"});
    CHECK_TEXT(run.status.has_value() && (run.status->code == 0 || run.status->code == 1), (what + ": " + run.err).c_str());
    CHECK_EQUAL("", run.out);
    LONGS_EQUAL_TEXT(run.status->code, std::ranges::count(run.err, '\n'), (what + ": " + run.err).c_str());
    if (run.status->code == 1) CHECK_TEXT(run.err.starts_with("strobe-raw: "), (what + ": " + run.err).c_str());
  }
};

// The directory lies behind the pixels.
TEST(RawRobustness, OfDirectoriesWithChangedBytes) {
  const std::string whole = dng_of(raw_picture());
  constexpr std::size_t kDirectory = 8 + 2 * kRawWidth * kRawHeight;
  constexpr unsigned kSeed = 32;
  std::mt19937 random(kSeed);
  for (int i = 0; i < 100; ++i) {
    std::string file = whole;
    for (auto changes = 1 + random() % 3; changes > 0; --changes)
      file[kDirectory + random() % (file.size() - kDirectory)] = static_cast<char>(random() % 4 == 0 ? 255 : random());
    check_end(fmt::format("mutation {} of seed {}", i, kSeed), file);
  }
}

TEST(RawRobustness, OfFilesCutShort) {
  const std::string whole = dng_of(raw_picture());
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 12)
    check_end(fmt::format("{} bytes", size), whole.substr(0, size));
}

// Sizes that would take more memory than the process may have, in files of a few kilobytes.
TEST(RawRobustness, OfSizesThatAreNotThere) {
  const std::string whole = dng_of(raw_picture());
  constexpr std::size_t kDirectory = 8 + 2 * kRawWidth * kRawHeight;
  constexpr std::size_t kWidthEntry = kDirectory + 2 + 12, kHeightEntry = kWidthEntry + 12;
  for (const std::size_t entries : {1U, 2U, 3U}) {
    for (const int top : {1, 127, 255}) {
      std::string file = whole;
      if (entries & 1U) file[kWidthEntry + 10] = static_cast<char>(top);
      if (entries & 2U) file[kHeightEntry + 10] = static_cast<char>(top);
      check_end(fmt::format("entries {}, {}", entries, top), file);
    }
  }
}
