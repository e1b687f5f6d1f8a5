#include "common/messages/well_formed.hpp"

#include <cmath>
#include <strobe_msgs/frame_2_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>

#include "common/messages/encoded_walk.hpp"

namespace strobe::messages {

using strobe_msgs::ball_image_t;
using strobe_msgs::frame_2_t;
using strobe_msgs::frame_t;

namespace {

ball_image_t with_tilt(const strobe_msgs::ball_image_2_t& image) {
  ball_image_t m;
  m.leg = image.leg;
  m.source = image.source;
  m.centre_x_px = image.centre_x_px;
  m.centre_y_px = image.centre_y_px;
  m.centre_xx_px2 = image.centre_xx_px2;
  m.centre_xy_px2 = image.centre_xy_px2;
  m.centre_yy_px2 = image.centre_yy_px2;
  m.diameter_px = image.diameter_px;
  m.diameter_sd_px = image.diameter_sd_px;
  m.equator_rad = image.equator_rad;
  m.equator_sd_rad = image.equator_sd_rad;
  m.top_x_px = image.top_x_px;
  m.top_y_px = image.top_y_px;
  m.contact_width_px = image.contact_width_px;
  m.equator_tilt_rad = m.equator_tilt_sd_rad = m.equator_tilt_correlation = std::nan("");
  return m;
}

void with_tilts(const frame_2_t& frame, frame_t& m) {
  m.schema_version = frame_t::SCHEMA_VERSION;
  m.boot_id = frame.boot_id;
  m.shot_id = frame.shot_id;
  m.host_id = frame.host_id;
  m.source = frame.source;
  m.photograph = frame.photograph;
  m.centre_sd_px = frame.centre_sd_px;
  m.diameter_sd_px = frame.diameter_sd_px;
  m.surface_sd_px = frame.surface_sd_px;
  m.equator_sd_rad = frame.equator_sd_rad;
  m.px_per_m = frame.px_per_m;
  m.px_per_m_sd = frame.px_per_m_sd;
  m.surface_count = frame.surface_count;
  m.surface = frame.surface;
  m.image_count = frame.image_count;
  m.images.clear();
  for (const auto& image : frame.images) m.images.push_back(with_tilt(image));
}

}  // namespace

bool decode_checked(frame_t& frame, const void* data, std::size_t size) {
  if (decode_checked<frame_t>(frame, data, size)) return true;
  frame_2_t former;
  if (!decode_checked<frame_2_t>(former, data, size) || former.schema_version != frame_2_t::SCHEMA_VERSION)
    return false;
  with_tilts(former, frame);
  return true;
}

std::int64_t readout_host(const void* data, std::size_t size) {
  EncodedWalk walk(data, size);
  const bool is_readout = walk.integer(8) == strobe_msgs::readout_t::getHash();
  walk.skip(4);  // schema_version
  const std::int64_t host = walk.integer(8);
  return is_readout ? host : 0;
}

}  // namespace strobe::messages
