// Assigns the sensors' edges to flashes. A flash's window runs from a little before it was issued (commanded,
// if it never was) for half the train's shortest interval: its first edge of each sensor is the flash.
// Further edges there, and every edge until the next flash is due, are light that nobody asked for and are
// counted as extra: such light makes an image as well. Edges before the first flash and a shortest interval
// after the last are not the train's. Either sensor may see either lamp: which one was to flash does not
// matter here. Real-time safe; no allocation beyond the record's capacity.
#pragma once

#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

class EdgeAssignment {
 public:
  /// A window begins this much before the flash was issued: covers what a configured sensor delay is wrong
  /// by.
  static constexpr Duration kEarly = microseconds(20);

  /// shortest: interval between two of its flashes.
  void open(ShotRecord& record, Duration shortest) noexcept;
  /// Enters a planned flash; in order of their instants.
  void plan(MonoTime commanded, Lamps lamps = Lamps::both) noexcept;
  void issued(std::int32_t flash_index, MonoTime start, MonoTime end) noexcept;
  /// seen: the stamp with the sensor's delay subtracted.
  void edge(Input sensor, MonoTime seen) noexcept;

 private:
  FlashRecord* latest_begun_by(MonoTime seen) noexcept;
  Duration until_next(const FlashRecord& flash) const noexcept;

  ShotRecord* record_ = nullptr;
  Duration shortest_{};
};

}  // namespace strobe::firmware
