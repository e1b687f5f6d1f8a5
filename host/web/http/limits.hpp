// How much the server takes on. Plain values.
#pragma once

#include <chrono>
#include <cstddef>

namespace strobe::web {

/// How long a viewer may take.
struct Patience {
  std::chrono::milliseconds first_request{5000};  ///< from connecting to a whole request
  std::chrono::milliseconds request{10000};       ///< from a later request's first byte to its last
  std::chrono::milliseconds idle{60000};          ///< between requests
  std::chrono::milliseconds write{10000};         ///< to read an answer, or a part of the event stream
};

struct Limits {
  std::size_t connections = 200;
  std::size_t viewers = 20;        ///< of the event stream
  std::size_t slow_requests = 16;  ///< that wait, of each worker
  Patience patience;
};

}  // namespace strobe::web
