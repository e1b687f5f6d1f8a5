// A simulated chip in a folder of its own, and programs that run with the library preloaded.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/gpiochip/chip.hpp"
#include "tests/sim/gpiochip/standard_chip.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::sim {

inline constexpr std::chrono::milliseconds kLimit{
    20'000};  // for what takes milliseconds; a loaded machine is slow

MonoTime now();

class ChipFixture {
 public:
  explicit ChipFixture(const ChipSpec& spec = standard_chip());

  Chip& chip() { return *chip_; }
  void remove_chip() { chip_.reset(); }
  const std::filesystem::path& logs() const { return logs_.path(); }
  std::filesystem::path chip_folder() const { return chip_folder_; }

  /// A command with the library preloaded; `first` names libraries to load before it.
  testing::Command preloaded(std::vector<std::string> arguments, const std::string& first = "") const;
  /// tests' actor in a role, started; failed unless it says "ready" or what `until` names.
  testing::Process actor(std::vector<std::string> role, const std::string& until = "ready",
                         const std::string& program = "gpio_actor") const;
  testing::CompletedProcess run(std::vector<std::string> arguments) const;

  /// Changes that came since the last call, waiting until there are `count` at least (or the limit passed).
  std::vector<Change> changes(std::size_t count);
  /// Of those, one line's levels in order.
  static std::vector<int> levels(const std::vector<Change>& changes, std::uint32_t line);

 private:
  testing::TemporaryFolder logs_;
  std::filesystem::path chip_folder_;
  std::unique_ptr<Chip> chip_;
  ChangeCursor cursor_;
};

/// A program of this build.
std::filesystem::path built_program(const std::string& name);

}  // namespace strobe::sim
