#include "tests/soak/disk.hpp"

#include <stdlib.h>  // NOLINT: mkdtemp

#include <algorithm>
#include <csignal>
#include <stdexcept>
#include <string>

namespace strobe::soak {

namespace fs = std::filesystem;

VirtualDisk::VirtualDisk() {
  std::error_code error;
  const fs::path memory = "/dev/shm";
  for (const fs::path& parent : {memory, fs::temp_directory_path(error)}) {
    std::string pattern = (parent / "strobe-soak-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) continue;
    path_ = pattern;
    return;
  }
  throw std::runtime_error("no folder can be made in /dev/shm nor in the temporary folder");
}

VirtualDisk::~VirtualDisk() {
  std::error_code error;
  fs::remove_all(path_, error);
}

void VirtualDisk::fill(std::uint64_t room) {
  std::uint64_t largest = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error))
    if (entry.is_regular_file(error)) largest = std::max<std::uint64_t>(largest, entry.file_size(error));
  most_ = largest + room;
}

VirtualDisk::Limit::Limit(std::uint64_t most) {
  handler_ = std::signal(SIGXFSZ, SIG_IGN);
  getrlimit(RLIMIT_FSIZE, &before_);
  const rlimit tight{most, before_.rlim_max};
  setrlimit(RLIMIT_FSIZE, &tight);
}

VirtualDisk::Limit::~Limit() {
  setrlimit(RLIMIT_FSIZE, &before_);
  std::signal(SIGXFSZ, handler_);
}

}  // namespace strobe::soak
