// A coded train: flashes at instants of their own, of both lamps or of one. Never allocates; copying takes as
// long as the train is, so that the room for the longest one costs nothing. Real-time safe.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>

#include "common/shot/lamps.hpp"
#include "common/units/time.hpp"

namespace strobe {

inline constexpr std::size_t kMaxCodedFlashes = 1024;

struct CodedFlash {
  Duration offset{};  ///< from the train's first instant
  Lamps lamps = Lamps::both;

  bool operator==(const CodedFlash&) const = default;
};

/// In order of time. Throws if it is full.
using CodedTrain = boost::container::static_vector<CodedFlash, kMaxCodedFlashes>;

}  // namespace strobe
