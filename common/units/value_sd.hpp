// A value with its standard deviation, both in the same unit. A plain value.
#pragma once

namespace strobe {

struct ValueSd {
  double value = 0.0;
  double sd = 0.0;
};

}  // namespace strobe
