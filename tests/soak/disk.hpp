// The disk behind the journal: a folder in memory whose files can be kept from growing, as on a full disk,
// even in the middle of a write. Files can be read at any time, also after the writer's end.
// The limit is the process's own (RLIMIT_FSIZE): one thread's, one at a time. POSIX.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace strobe::soak {

class VirtualDisk {
 public:
  /// Makes an empty folder in /dev/shm, or else in the system's temporary one. std::runtime_error: it cannot.
  VirtualDisk();
  VirtualDisk(const VirtualDisk&) = delete;
  VirtualDisk& operator=(const VirtualDisk&) = delete;
  ~VirtualDisk();

  const std::filesystem::path& path() const { return path_; }

  /// From now on no file grows beyond the largest one's present size and `room` bytes.
  void fill(std::uint64_t room);
  void make_room() { most_.reset(); }
  bool full() const { return most_.has_value(); }

  /// Calls `run`, whose writes to the disk are cut short and then fail beyond the limit.
  template <typename Write>
  void write(Write&& run) {
    if (!most_) return run();
    const Limit limit(*most_);
    run();
  }

 private:
  class Limit {
   public:
    explicit Limit(std::uint64_t most);
    ~Limit();

   private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
  };

  std::filesystem::path path_;
  std::optional<std::uint64_t> most_;
};

}  // namespace strobe::soak
