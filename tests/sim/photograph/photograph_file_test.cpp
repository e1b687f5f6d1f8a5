#include "sim/photograph/render.hpp"

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <string>

#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::sim;
namespace fs = std::filesystem;

/// All numbers of the type, in an order that no compression shortens.
cv::Mat numbers(int type, int step) {
  cv::Mat pixels(40, 60, type);
  for (int row = 0; row < pixels.rows; ++row) {
    for (int column = 0; column < pixels.cols; ++column) {
      const int number = (row * pixels.cols + column) * step;
      if (type == CV_8UC1)
        pixels.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(number);
      else
        pixels.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(number);
    }
  }
  return pixels;
}

/// What the kernel tells of a folder's files, as "name:what " in the order that it happened.
class FolderEar {
 public:
  explicit FolderEar(const fs::path& folder) : descriptor_(inotify_init1(IN_NONBLOCK)) {
    inotify_add_watch(descriptor_, folder.c_str(),
                      IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE);
  }
  FolderEar(const FolderEar&) = delete;
  FolderEar& operator=(const FolderEar&) = delete;
  ~FolderEar() { close(descriptor_); }

  std::string heard() {
    alignas(inotify_event) std::array<char, 8192> buffer{};
    const ssize_t size = read(descriptor_, buffer.data(), buffer.size());
    std::string text;
    for (ssize_t at = 0; at < size;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      text += std::string(event->name) + ":" + word(event->mask) + " ";
      at += static_cast<ssize_t>(sizeof(inotify_event)) + event->len;
    }
    return text;
  }

 private:
  static const char* word(std::uint32_t mask) {
    if ((mask & IN_CREATE) != 0) return "created";
    if ((mask & IN_CLOSE_WRITE) != 0) return "closed";
    if ((mask & IN_MOVED_FROM) != 0) return "from";
    if ((mask & IN_MOVED_TO) != 0) return "to";
    return "deleted";
  }
  int descriptor_;
};

}  // namespace

TEST_GROUP(PhotographFile) { strobe::testing::TemporaryFolder folder; };

TEST(PhotographFile, KeepsEveryNumber) {
  for (const auto& [type, step] : {std::pair{CV_8UC1, 1}, std::pair{CV_16UC1, 27}}) {
    for (const PhotographFormat format : {PhotographFormat::tiff, PhotographFormat::png}) {
      const cv::Mat pixels = numbers(type, step);
      const fs::path path = folder / ("a" + extension(format));
      CHECK_TRUE(write_photograph(path, pixels, format).has_value());
      const cv::Mat read = strobe::testing::read_picture(path);
      LONGS_EQUAL(type, read.type());
      CHECK_EQUAL(0.0, cv::norm(pixels, read, cv::NORM_INF));
    }
  }
}

TEST(PhotographFile, IsAsLargeAsItsPixelsWhereItIsNotCompressed) {
  const fs::path path = folder / "a.tif";
  CHECK_TRUE(write_photograph(path, cv::Mat::zeros(40, 60, CV_16UC1), PhotographFormat::tiff).has_value());
  CHECK(fs::file_size(path) >= 40 * 60 * 2);
}

TEST(PhotographFile, AppearsUnderItsNameOnlyWhenItIsWhole) {
  FolderEar ear(folder.path());
  CHECK_TRUE(write_photograph(folder / "a.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff).has_value());
  CHECK_EQUAL("a.tif.part:created a.tif.part:closed a.tif.part:from a.tif:to ", ear.heard());
}

TEST(PhotographFile, BearsTheTimeThatItIsGivenBeforeItAppears) {
  const strobe::WallTime written{std::chrono::sys_days{std::chrono::year{2000} / 1 / 1}};
  const fs::path path = folder / "a.tif";
  CHECK_TRUE(write_photograph(path, numbers(CV_8UC1, 1), PhotographFormat::tiff, written).has_value());
  CHECK(std::chrono::file_clock::to_sys(fs::last_write_time(path)) == written);
}

TEST(PhotographFile, ThatCannotBeWrittenIsNamedAndLeavesNothing) {
  const auto absent = write_photograph(folder / "no/a.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff);
  CHECK_FALSE(absent.has_value());
  STRCMP_CONTAINS("no/a.tif: cannot be written", absent.error().message.c_str());
  // A folder of that name cannot be replaced by a file.
  fs::create_directories(folder / "b.tif" / "full");
  const auto taken = write_photograph(folder / "b.tif", numbers(CV_8UC1, 1), PhotographFormat::tiff);
  CHECK_FALSE(taken.has_value());
  CHECK_FALSE(fs::exists(folder / "b.tif.part"));
  const auto empty = write_photograph(folder / "c.tif", cv::Mat(), PhotographFormat::tiff);
  CHECK_FALSE(empty.has_value());
  STRCMP_CONTAINS("c.tif: cannot be encoded", empty.error().message.c_str());
}
