#include "host/drivers/genicam/frame_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <system_error>

#include "common/config/files.hpp"
#include "common/image/image_files.hpp"

namespace strobe::genicam {
namespace {

/// From one row to the next.
Result<std::size_t> checked_stride(const Frame& frame, const PixelFormat& format) {
  if (frame.width <= 0 || frame.height <= 0 || frame.row_padding < 0 ||
      image::kMaxPixels / frame.height < frame.width)
    return fail(fmt::format("a frame of {} x {} pixels", frame.width, frame.height));
  const auto row = row_bytes(format, frame.width);
  if (!row)
    return fail(fmt::format("rows of {} pixels of {} do not end with a byte", frame.width, format.name));
  const std::size_t stride = *row + static_cast<std::size_t>(frame.row_padding);
  if (stride * static_cast<std::size_t>(frame.height - 1) + *row > frame.bytes.size())
    return fail(fmt::format("{} bytes are too few for {} x {} pixels of {}", frame.bytes.size(), frame.width,
                            frame.height, format.name));
  return stride;
}

/// One row after the other, 16 bits each where the format is packed or a colour sensor's.
std::vector<std::uint8_t> rearranged(const Frame& frame, const PixelFormat& format, std::size_t stride,
                                     std::size_t row, int bits) {
  const auto width = static_cast<std::size_t>(frame.width), height = static_cast<std::size_t>(frame.height);
  const std::size_t row_to = width * static_cast<std::size_t>(bits) / 8;
  std::vector<std::uint8_t> rows(row_to * height);
  std::vector<std::uint16_t> numbers(width);
  for (std::size_t y = 0; y < height; ++y) {
    const auto from = frame.bytes.subspan(stride * y, row);
    if (row == row_to) {
      std::memcpy(rows.data() + row_to * y, from.data(), row);
    } else {
      unpack_row(format, from, numbers);
      std::memcpy(rows.data() + row_to * y, numbers.data(), row_to);
    }
  }
  return rows;
}

static_assert(std::endian::native == std::endian::little, "cameras' numbers are taken as they are");

/// Header and directory, TIFF 6.0: all values are so short that they lie in their entries.
class TiffStart {
 public:
  void add(std::uint16_t tag, std::uint32_t value) { add(tag, kLong, 1, value); }
  void add_mosaic(const std::array<std::uint8_t, 4>& tile, std::uint32_t white) {
    constexpr std::uint16_t kByte = 1, kShort = 3;
    std::uint32_t colours = 0;
    std::memcpy(&colours, tile.data(), tile.size());
    add(33421, kShort, 2, 2U << 16 | 2U);  // CFARepeatPatternDim
    add(33422, kByte, 4, colours);         // CFAPattern
    add(50714, 0);                         // BlackLevel
    add(50717, white);                     // WhiteLevel
  }
  std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0, static_cast<std::uint8_t>(entries_.size()),
                                    0};
    const auto* first = reinterpret_cast<const std::uint8_t*>(entries_.data());
    bytes.insert(bytes.end(), first, first + entries_.size() * sizeof(Entry));
    bytes.resize(kSize);
    return bytes;
  }
  /// Where pixels begin.
  static constexpr std::uint32_t kSize = 256;

 private:
  static constexpr std::uint16_t kLong = 4;
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count, value;
  };
  static_assert(sizeof(Entry) == 12);
  void add(std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::uint32_t value) {
    entries_.push_back({tag, type, count, value});
  }
  std::vector<Entry> entries_;
};

std::vector<std::uint8_t> tiff_start(const Frame& frame, const PixelFormat& format, int bits,
                                     std::size_t size) {
  constexpr std::uint32_t kUncompressed = 1, kBlackIsZero = 1, kColourFilterArray = 32803;
  const auto mosaic = format.mosaic();
  const auto height = static_cast<std::uint32_t>(frame.height);
  TiffStart start;
  start.add(256, static_cast<std::uint32_t>(frame.width));
  start.add(257, height);
  start.add(258, static_cast<std::uint32_t>(bits));
  start.add(259, kUncompressed);
  start.add(262, mosaic ? kColourFilterArray : kBlackIsZero);
  start.add(273, TiffStart::kSize);
  start.add(277, 1);       // numbers a pixel
  start.add(278, height);  // rows of the only strip
  start.add(279, static_cast<std::uint32_t>(size));
  if (mosaic) start.add_mosaic(*mosaic, (1U << format.bits) - 1U);
  return start.bytes();
}

class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : fd_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

Result<TiffFile> tiff_of(const Frame& frame) {
  const PixelFormat* format = find_pixel_format(frame.pixel_format);
  if (format == nullptr) return fail(fmt::format("pixels of the format {:#x}", frame.pixel_format));
  const auto stride = checked_stride(frame, *format);
  if (!stride) return tl::unexpected(stride.error());
  const std::size_t row = *row_bytes(*format, frame.width);
  const int bits = format->bits == 8 && format->tile.empty() ? 8 : 16;
  TiffFile tiff;
  if (format->bits_in_memory() == bits && *stride == row) {
    tiff.pixels = frame.bytes.first(row * static_cast<std::size_t>(frame.height));
  } else {
    tiff.unpacked = rearranged(frame, *format, *stride, row, bits);
    tiff.pixels = tiff.unpacked;
  }
  tiff.start = tiff_start(frame, *format, bits, tiff.pixels.size());
  return tiff;
}

Result<std::string> put_file(const std::filesystem::path& folder, const std::string& stem,
                             const TiffFile& tiff, WallTime ended) {
  std::string name = stem + ".tif";
  std::error_code error;
  for (int next = 2; std::filesystem::exists(folder / name, error); ++next)
    name = fmt::format("{}-{}.tif", stem, next);
  const std::filesystem::path draft = folder / ("." + name + ".part");
  const OpenFile file(draft);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(ended);
  timespec time{};
  time.tv_sec = seconds.time_since_epoch().count();
  time.tv_nsec = (ended - seconds).count();
  const std::array<timespec, 2> times{time, time};
  const auto text = [](std::span<const std::uint8_t> bytes) {
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  if (file.get() >= 0 && config::write_all(file.get(), text(tiff.start)) &&
      config::write_all(file.get(), text(tiff.pixels)) && ::futimens(file.get(), times.data()) == 0 &&
      ::rename(draft.c_str(), (folder / name).c_str()) == 0)
    return name;
  auto failed = fail(fmt::format("{}: {}", (folder / name).string(), std::strerror(errno)));
  ::unlink(draft.c_str());
  return failed;
}

}  // namespace strobe::genicam
