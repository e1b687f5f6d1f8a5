// The simulated camera's memory card: files in a folder, listed, described and read as objects of PTP (ISO
// 15740:2013, clause 6): DCIM, in it a folder of the camera, in that files named DSC_0001 to DSC_9999; after
// that the next folder begins with DSC_0001 again (DCF, CIPA DC-009). One thread at a time; reads and removes
// files.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "sim/ptp/packets.hpp"

namespace strobe::sim::ptp {

class Card {
 public:
  static constexpr std::uint32_t kStorage = 0x00010001;
  static constexpr std::uint64_t kCapacity = 64'000'000'000;

  /// `first_number`: of the next file, 1 to 9999.
  explicit Card(std::filesystem::path folder, int first_number = 1);

  /// Of the next photograph: where its files are to be put, without their extensions.
  std::filesystem::path next_stem();
  /// A file that has been put there. `taken`: YYYYMMDDThhmmss. Returns its handle.
  std::uint32_t add(const std::filesystem::path& file, ObjectFormat format, const std::string& taken);

  /// There is no room any more, or there is again.
  void set_full(bool full) { full_ = full; }
  bool full() const { return full_; }

  Answer storage_info(std::uint32_t storage) const;
  /// `parent` 0: all; 0xFFFFFFFF: those in none.
  Answer handles(std::uint32_t storage, std::uint32_t format, std::uint32_t parent) const;
  Answer count(std::uint32_t storage, std::uint32_t format, std::uint32_t parent) const;
  Answer info(std::uint32_t handle) const;
  Answer read(std::uint32_t handle, std::uint64_t offset, std::uint64_t length) const;
  Response remove(std::uint32_t handle);

 private:
  struct Object {
    std::filesystem::path file;  ///< its name alone for a folder
    ObjectFormat format = ObjectFormat::association;
    std::uint32_t parent = 0;  ///< 0: none
    std::uint64_t size = 0;
    std::string taken{};
  };
  bool matches(const Object& object, std::uint32_t format, std::uint32_t parent) const;
  void begin_folder();

  std::filesystem::path folder_;
  std::map<std::uint32_t, Object> objects_;  ///< by handle
  std::uint32_t last_handle_ = 0, folder_handle_ = 0;
  int folder_number_ = 99, number_;
  bool full_ = false;
};

}  // namespace strobe::sim::ptp
