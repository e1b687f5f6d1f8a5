#include "common/image/tiff_memory.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace strobe::image {

namespace {

/// No single piece of memory of libtiff's is larger than the largest picture.
constexpr tmsize_t kMaxMemory = 6 * kMaxPixels;

TiffMemory& memory_of(thandle_t handle) { return *static_cast<TiffMemory*>(handle); }

std::uint64_t size_of(const TiffMemory& memory) {
  return memory.written != nullptr ? memory.written->size() : memory.bytes.size();
}

tmsize_t read(thandle_t handle, void* to, tmsize_t count) {
  TiffMemory& memory = memory_of(handle);
  const std::uint64_t size = size_of(memory);
  const std::uint64_t there =
      memory.at < size ? std::min(size - memory.at, static_cast<std::uint64_t>(count)) : 0;
  const unsigned char* from = memory.written != nullptr ? memory.written->data() : memory.bytes.data();
  if (there > 0) std::memcpy(to, from + memory.at, there);
  memory.at += there;
  return static_cast<tmsize_t>(there);
}

tmsize_t write(thandle_t handle, void* from, tmsize_t count) {
  TiffMemory& memory = memory_of(handle);
  if (memory.written == nullptr) return -1;
  const std::uint64_t end = memory.at + static_cast<std::uint64_t>(count);
  try {
    if (end > memory.written->size()) memory.written->resize(end);
  } catch (const std::exception&) {  // none may pass through libtiff
    return -1;
  }
  std::memcpy(memory.written->data() + memory.at, from, static_cast<std::size_t>(count));
  memory.at = end;
  return count;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
  TiffMemory& memory = memory_of(handle);
  memory.at = offset + (whence == SEEK_CUR ? memory.at : whence == SEEK_END ? size_of(memory) : 0);
  return memory.at;
}

int close(thandle_t) { return 0; }

toff_t size(thandle_t handle) { return size_of(memory_of(handle)); }

int map(thandle_t handle, void** base, toff_t* size) {
  const TiffMemory& memory = memory_of(handle);
  if (memory.written != nullptr) return 0;
  *base = const_cast<unsigned char*>(memory.bytes.data());  // libtiff only reads it
  *size = memory.bytes.size();
  return 1;
}

void unmap(thandle_t, void*, toff_t) {}

int on_error(TIFF*, void* data, const char*, const char* format, va_list values) {
  auto& memory = *static_cast<TiffMemory*>(data);
  std::array<char, 200> text{};
  std::vsnprintf(text.data(), text.size(), format, values);
  if (memory.words.empty()) memory.words = text.data();
  return 1;
}

int on_warning(TIFF*, void* data, const char*, const char* format, va_list) {
  if (std::strncmp(format, "IO error", 8) == 0) static_cast<TiffMemory*>(data)->lost_a_tag = true;
  return 1;
}

}  // namespace

OpenTiff open_tiff(TiffMemory& memory) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                 TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxMemory);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, &memory);
  const char* mode = memory.written != nullptr ? "w" : "r";
  return OpenTiff(
      TIFFClientOpenExt("", mode, &memory, read, write, seek, close, size, map, unmap, options.get()));
}

}  // namespace strobe::image
