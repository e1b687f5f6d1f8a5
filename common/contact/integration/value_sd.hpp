// A value with its standard deviation, in the same unit.
#pragma once

namespace strobe::contact {

struct ValueSd {
  double value = 0.0;
  double sd = 0.0;
};

}  // namespace strobe::contact
