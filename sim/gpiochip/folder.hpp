// The chip's folder, opened by the rig: created, mapped, and removed by its creator.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

/// Move-only. The creator holds both ends of every FIFO, so that readers never see an end while it
/// lives.
class ChipFolder {
 public:
  static Result<ChipFolder> create(const std::filesystem::path& dir, const ChipSpec& spec);
  static Result<ChipFolder> attach(const std::filesystem::path& dir);
  ChipFolder() = default;
  ChipFolder(ChipFolder&& other) noexcept;
  ChipFolder& operator=(ChipFolder&& other) noexcept;
  ~ChipFolder();

  void close_events();

  std::filesystem::path path;
  State* state = nullptr;
  int lock_fd = -1;
  std::vector<int> events;    ///< one per line, -1 once closed
  std::vector<int> requests;  ///< one per possible v2 request, of which there are as many as lines

 private:
  Result<void> make_files(std::size_t lines);
  Result<void> publish(const ChipSpec& spec);
  Result<void> open_common(std::size_t lines);
  void remove_files();
  void reset();

  int device_fd_ = -1;
  std::vector<int> watches_;  ///< the creator's
  bool made_folder_ = false;
  bool made_chip_ = false;
};

}  // namespace strobe::sim::gpio
