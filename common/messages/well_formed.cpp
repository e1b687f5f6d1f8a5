#include "common/messages/well_formed.hpp"

#include <strobe_msgs/readout_t.hpp>

#include "common/messages/encoded_walk.hpp"

namespace strobe::messages {

std::int64_t readout_host(const void* data, std::size_t size) {
  EncodedWalk walk(data, size);
  const bool is_readout = walk.integer(8) == strobe_msgs::readout_t::getHash();
  walk.skip(4);  // schema_version
  const std::int64_t host = walk.integer(8);
  return is_readout ? host : 0;
}

}  // namespace strobe::messages
