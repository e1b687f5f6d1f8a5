// The numbers of a session folder's shots: none is ever used twice, also where a power cut took the journal's
// last events, which were obeyed before they could be synced. Numbers are set aside on the disk before they
// are used, in the file `shot-numbers`: the highest that may have been used. Only an orderly end gives back
// what is left of them, so that after any other a few numbers are left out. Not real-time; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "common/result.hpp"

namespace strobe::firmware {

class ShotNumbers {
 public:
  /// So many are set aside at once, when fewer than half are left: shots go on while the disk is slow.
  static constexpr std::int32_t kAtOnce = 16;

  /// The highest number that may have been used; nullopt if the folder's file is not there or cannot be
  /// understood.
  static std::optional<std::int32_t> read(const std::filesystem::path& dir);

  /// last_in_journals: the highest that the folder's journals have. Where the file is missing beside them,
  /// kAtOnce numbers are left out.
  ShotNumbers(std::filesystem::path dir, std::int32_t last_in_journals);

  /// The highest number that any shot before this start may have had.
  std::int32_t last_before() const { return last_before_; }
  /// The highest that may be used.
  std::int32_t limit() const { return limit_; }
  /// Sets further ones aside if fewer than half are left; limit() rises once they are on the disk. Fails with
  /// the path and the cause. last_used: by a shot of this start, or last_before().
  Result<void> set_aside(std::int32_t last_used);
  /// At an orderly end, when the journal is on the disk.
  Result<void> give_back(std::int32_t last_used);

 private:
  Result<void> write(std::int32_t highest) const;

  std::filesystem::path dir_;
  std::int32_t last_before_ = 0;
  std::int32_t limit_ = 0;
};

}  // namespace strobe::firmware
