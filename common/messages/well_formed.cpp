#include "common/messages/well_formed.hpp"

#include <cassert>
#include <cstdint>
#include <strobe_msgs/frame_2_t.hpp>
#include <strobe_msgs/frame_3_t.hpp>
#include <strobe_msgs/frame_4_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <utility>
#include <vector>

#include "common/messages/encoded_walk.hpp"

namespace strobe::messages {

using strobe_msgs::frame_t;

namespace {

/// Of a former type, whose fields the present one begins with. All bits set are NaN: a number that is not
/// there.
template <typename Former, typename Present>
void take_over(const Former& former, Present& present) {
  present = Present{};
  std::vector<std::uint8_t> bytes(
      static_cast<std::size_t>(former._getEncodedSizeNoHash() + present._getEncodedSizeNoHash()), 0xff);
  const int size = static_cast<int>(bytes.size());
  [[maybe_unused]] const int written = former._encodeNoHash(bytes.data(), 0, size);
  [[maybe_unused]] const int read = present._decodeNoHash(bytes.data(), 0, size);
  assert(written > 0 && read > 0);
}

template <typename Former>
bool decode_former(frame_t& frame, const void* data, std::size_t size) {
  Former former;
  if (!decode_checked<Former>(former, data, size) || former.schema_version != Former::SCHEMA_VERSION)
    return false;
  const auto images = std::exchange(former.images, {});
  former.image_count = 0;
  take_over(former, frame);
  frame.schema_version = frame_t::SCHEMA_VERSION;
  frame.image_count = static_cast<std::int32_t>(images.size());
  for (const auto& image : images) take_over(image, frame.images.emplace_back());
  return true;
}

}  // namespace

bool decode_checked(frame_t& frame, const void* data, std::size_t size) {
  return decode_checked<frame_t>(frame, data, size) ||
         decode_former<strobe_msgs::frame_4_t>(frame, data, size) ||
         decode_former<strobe_msgs::frame_3_t>(frame, data, size) ||
         decode_former<strobe_msgs::frame_2_t>(frame, data, size);
}

std::int64_t readout_host(const void* data, std::size_t size) {
  EncodedWalk walk(data, size);
  const bool is_readout = walk.integer(8) == strobe_msgs::readout_t::getHash();
  walk.skip(4);  // schema_version
  const std::int64_t host = walk.integer(8);
  return is_readout ? host : 0;
}

}  // namespace strobe::messages
