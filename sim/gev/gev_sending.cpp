// Frames of the simulated camera: made, lost, sent.
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>

#include "sim/gev/gev_camera.hpp"

namespace strobe::sim::gev {
namespace {

// A receiver reads nothing while this thread runs: what is sent at once must fit into its socket.
constexpr std::size_t kBurst = 32 * 1024;
constexpr std::size_t kKeptFrames = 4;
constexpr std::uint32_t kMaxUnavailable = 64;  // answers to one request
constexpr std::uint32_t kEndlessPackets = 0xffffff;
constexpr double kBitsPerByte = 8.0;
constexpr std::uint32_t kAddressHeaders = 28;  // IP and UDP

using Hostile = CameraLinkSettings::Hostile;

std::uint16_t after(std::uint16_t block) {
  return block == 0xffff ? 1 : static_cast<std::uint16_t>(block + 1);
}

}  // namespace

bool GevCamera::has(FaultKind kind, const Waiting& waiting) const {
  return waiting.exposure && shot_fault(scene_.faults, kind, waiting.exposure->shot) != nullptr;
}

void GevCamera::make_frames() {
  const MonoTime now = clock_.now();
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    if (now < waiting.due) return false;
    make_frame(waiting);
    return true;
  });
}

/// What its automatic modes do from one frame to the next.
void GevCamera::adjust_by_itself() {
  constexpr double kMaxGain_dB = 12.0, kShortest_us = 2'000.0, kLongest_us = 20'000.0;
  const double gain_dB = kMaxGain_dB * draws_.uniform();
  const double exposure_us = kShortest_us + (kLongest_us - kShortest_us) * draws_.uniform();
  if (device_->word(camera::kGainAuto) != 0) device_->set_number(camera::kGain, gain_dB);
  if (device_->word(camera::kExposureAuto) != 0) device_->set_number(camera::kExposureTime, exposure_us);
}

void GevCamera::make_frame(const Waiting& waiting) {
  if (!device_->acquires()) return;
  adjust_by_itself();
  auto pixels = pixels_of(waiting);
  if (!pixels) return;  // too large, which create() refuses
  if (has(FaultKind::frame_twice, waiting)) queue_frame(*pixels, waiting);
  queue_frame(std::move(*pixels), waiting);
  if (device_->word(camera::kAcquisitionMode) != 0) device_->stop_acquisition();
  if (!has(FaultKind::camera_auto, waiting)) return;
  device_->set_word(camera::kExposureAuto, 1);
  device_->set_word(camera::kGainAuto, 1);
  device_->set_word(camera::kExposureMode, 0);
}

Result<Packet> GevCamera::pixels_of(const Waiting& waiting) {
  const PictureSettings settings = picture_settings(*device_);
  if (waiting.exposure) return shot_pixels(scene_, seed_, *waiting.exposure, settings);
  if (room_settings_ == settings) return room_;
  auto pixels = room_pixels(scene_, seed_, settings);
  if (!pixels) return pixels;
  room_settings_ = settings;
  room_ = *pixels;
  return pixels;
}

void GevCamera::queue_frame(Packet pixels, const Waiting& waiting) {
  block_ = after(block_);
  const bool dropped = draws_.uniform() < scene_.camera_link.drop || has(FaultKind::frame_dropped, waiting);
  if (dropped) return;
  auto kept = std::make_shared<Kept>();
  StreamFrame& frame = kept->frame;
  frame.block = block_;
  frame.timestamp = device_->ticks(waiting.begun);
  frame.pixel_format = device_->pixel_format();
  frame.width = device_->word(camera::kWidth);
  frame.height = device_->word(camera::kHeight);
  frame.packet_size = device_->word(bootstrap::kPacketSize);
  frame.pixels = std::move(pixels);
  const Hostile hostile = scene_.camera_link.hostile;
  if (hostile == Hostile::sizes) {
    frame.width *= 4;
    frame.height *= 4;
    frame.pixels.resize(2 * frame.pixels.size());
  }
  const std::uint32_t count = packet_count(frame);
  if (has(FaultKind::frame_incomplete, waiting)) {
    for (int i = 0; i < 3; ++i)
      kept->gone.push_back(1 + static_cast<std::uint32_t>((count - 2) * draws_.uniform()));
  }
  kept_.push_back(kept);
  if (kept_.size() > kKeptFrames) kept_.pop_front();
  sending_.push_back({kept, 0, hostile == Hostile::endless ? kEndlessPackets : count, false});
}

void GevCamera::queue_resends() {
  for (const PacketRange& range : device_->take_resend_requests()) queue_resend(range);
}

void GevCamera::queue_resend(const PacketRange& range) {
  const auto found =
      std::ranges::find(kept_, range.block, [](const auto& kept) { return kept->frame.block; });
  if (found != kept_.end()) {
    const std::uint32_t end = std::min(range.last + 1, packet_count((*found)->frame));
    if (range.first < end) sending_.push_front({*found, range.first, end, true});
    return;
  }
  const std::uint32_t last = std::min(range.last, range.first + kMaxUnavailable);
  for (std::uint32_t id = range.first; id <= last; ++id) send(unavailable_packet(range.block, id));
}

bool GevCamera::is_lost(const Sending& sending, std::uint32_t id) {
  const CameraLinkSettings& link = scene_.camera_link;
  const bool lost = draws_.uniform() < (sending.resent ? link.resend_loss : link.loss);
  return lost || std::ranges::find(sending.kept->gone, id) != sending.kept->gone.end();
}

void GevCamera::send_some() {
  const MonoTime now = clock_.now();
  if (!device_->stream_destination()) sending_.clear();
  if (sending_.empty() || now < send_at_) return;
  std::size_t sent = 0;
  while (!sending_.empty() && sent < kBurst) {
    Sending& sending = sending_.front();
    const Packet packet = stream_packet(sending.kept->frame, sending.next);
    if (!is_lost(sending, sending.next)) send(packet);
    sent += packet.size();
    if (++sending.next >= sending.end) sending_.pop_front();
  }
  const double link_s = kBitsPerByte * static_cast<double>(sent) / rate_bps_;
  send_at_ = now + from_seconds(link_s);
}

void GevCamera::send_test_packet() { send(Packet(device_->word(bootstrap::kPacketSize) - kAddressHeaders)); }

void GevCamera::send(const Packet& packet) {
  const auto to = device_->stream_destination();
  if (!to) return;
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(to->address);
  place.sin_port = htons(to->port);
  sendto(stream_socket_, packet.data(), packet.size(), MSG_DONTWAIT,
         reinterpret_cast<const sockaddr*>(&place), sizeof place);
}

}  // namespace strobe::sim::gev
