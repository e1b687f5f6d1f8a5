// A coded train: flashes at instants of their own, of both lamps or of one. Copying takes as long as the
// train is, so that the room for the longest one costs nothing where there is none. Real-time safe; no
// allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "common/shot/lamps.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

inline constexpr std::size_t kMaxCodedFlashes = 1024;

struct CodedFlash {
  Duration offset{};  ///< from the train's first instant
  Lamps lamps = Lamps::both;

  bool operator==(const CodedFlash&) const = default;
};

class CodedTrain {
 public:
  CodedTrain() noexcept {}  // NOLINT(modernize-use-equals-default): the arrays are left as they are
  CodedTrain(const CodedTrain& other) noexcept { *this = other; }
  CodedTrain& operator=(const CodedTrain& other) noexcept {
    count_ = other.count_;
    std::copy_n(other.offsets_ns_.begin(), count_, offsets_ns_.begin());
    std::copy_n(other.lamps_.begin(), count_, lamps_.begin());
    return *this;
  }
  ~CodedTrain() = default;

  bool empty() const noexcept { return count_ == 0; }  ///< an even train
  std::size_t size() const noexcept { return count_; }
  CodedFlash operator[](std::size_t i) const noexcept { return {nanoseconds(offsets_ns_[i]), lamps_[i]}; }
  CodedFlash back() const noexcept { return (*this)[count_ - 1]; }
  /// False: full, nothing is added.
  bool push_back(const CodedFlash& flash) noexcept {
    if (count_ == kMaxCodedFlashes) return false;
    offsets_ns_[count_] = flash.offset.count();
    lamps_[count_] = flash.lamps;
    ++count_;
    return true;
  }

 private:
  std::size_t count_ = 0;
  std::array<std::int64_t, kMaxCodedFlashes> offsets_ns_;
  std::array<Lamps, kMaxCodedFlashes> lamps_;
};

}  // namespace strobe::firmware
