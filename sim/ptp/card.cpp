#include "sim/ptp/card.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "sim/ptp/dataset.hpp"

namespace strobe::sim::ptp {

namespace {

namespace fs = std::filesystem;

constexpr int kLastNumber = 9999;
constexpr std::uint32_t kDcim = 1;            // handle
constexpr std::uint32_t kEvery = 0xFFFFFFFF;  // storage; as parent: in no folder
constexpr std::uint64_t kLikelySize = 25'000'000;

}  // namespace

Card::Card(fs::path folder, int first_number) : folder_(std::move(folder)), number_(first_number - 1) {
  objects_[++last_handle_] = {"DCIM"};
  begin_folder();
}

void Card::begin_folder() {
  folder_handle_ = ++last_handle_;
  objects_[folder_handle_] = {fmt::format("{}STROB", ++folder_number_), ObjectFormat::association, kDcim};
}

fs::path Card::next_stem() {
  if (number_ == kLastNumber) {
    begin_folder();
    number_ = 0;
  }
  const fs::path folder = folder_ / objects_[folder_handle_].file;
  std::error_code error;
  fs::create_directories(folder, error);
  return folder / fmt::format("DSC_{:04}", ++number_);
}

std::uint32_t Card::add(const fs::path& file, ObjectFormat format, const std::string& taken) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  objects_[++last_handle_] = {file, format, folder_handle_, error ? 0 : size, taken};
  return last_handle_;
}

Answer Card::storage_info(std::uint32_t storage) const {
  if (storage != kStorage) return {Response::invalid_storage, {}, {}};
  std::uint64_t used = 0;
  for (const auto& [handle, object] : objects_) used += object.size;
  const std::uint64_t free = full_ || used >= kCapacity ? 0 : kCapacity - used;
  constexpr int kRemovableRam = 4, kDcf = 3, kReadWrite = 0;
  return {Response::ok,
          {},
          DatasetWriter()
              .u16(kRemovableRam)
              .u16(kDcf)
              .u16(kReadWrite)
              .u64(kCapacity)
              .u64(free)
              .u32(free / kLikelySize)
              .text("Memory card")
              .text("")
              .take()};
}

bool Card::matches(const Object& object, std::uint32_t format, std::uint32_t parent) const {
  const bool here = parent == 0 || object.parent == (parent == kEvery ? 0 : parent);
  return here && (format == 0 || format == number(object.format));
}

Answer Card::handles(std::uint32_t storage, std::uint32_t format, std::uint32_t parent) const {
  if (storage != kStorage && storage != kEvery) return {Response::invalid_storage, {}, {}};
  std::vector<std::uint32_t> found;
  for (const auto& [handle, object] : objects_) {
    if (matches(object, format, parent)) found.push_back(handle);
  }
  return {Response::ok, {}, DatasetWriter().array32(found).take()};
}

Answer Card::count(std::uint32_t storage, std::uint32_t format, std::uint32_t parent) const {
  if (storage != kStorage && storage != kEvery) return {Response::invalid_storage, {}, {}};
  const auto found = std::ranges::count_if(
      objects_, [&](const auto& entry) { return matches(entry.second, format, parent); });
  return {Response::ok, {static_cast<std::uint32_t>(found)}, {}};
}

Answer Card::info(std::uint32_t handle) const {
  const auto found = objects_.find(handle);
  if (found == objects_.end()) return {Response::invalid_object, {}, {}};
  const Object& object = found->second;
  const bool folder = object.format == ObjectFormat::association;
  DatasetWriter writer;
  writer.u32(kStorage).u16(number(object.format)).u16(0).u32(object.size);
  writer.u16(0).u32(0).u32(0).u32(0);              // no small picture
  writer.u32(0).u32(0).u32(0).u32(object.parent);  // width, height, bits: not told
  writer.u16(folder ? 1 : 0).u32(0).u32(0);        // association type: a generic folder
  writer.text(object.file.filename().string()).text(object.taken).text(object.taken).text("");
  return {Response::ok, {}, writer.take()};
}

Answer Card::read(std::uint32_t handle, std::uint64_t offset, std::uint64_t length) const {
  const auto found = objects_.find(handle);
  if (found == objects_.end() || found->second.format == ObjectFormat::association)
    return {Response::invalid_object, {}, {}};
  const std::uint64_t size = found->second.size;
  Bytes data(std::min(length, size - std::min(offset, size)));
  std::ifstream file(found->second.file, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()));
  data.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  const auto sent = static_cast<std::uint32_t>(data.size());
  return {Response::ok, {sent}, std::move(data)};
}

Response Card::remove(std::uint32_t handle) {
  const auto found = objects_.find(handle);
  if (found == objects_.end()) return Response::invalid_object;
  if (found->second.format == ObjectFormat::association) return Response::access_denied;
  std::error_code error;
  fs::remove(found->second.file, error);
  objects_.erase(found);
  return Response::ok;
}

}  // namespace strobe::sim::ptp
