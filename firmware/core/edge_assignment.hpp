// Assigns the sensors' edges to flashes. A flash's window begins shortly before it was issued (commanded, if
// it never was) and lasts half the train's shortest interval; the first edge of each sensor in it is the
// flash. Further edges there, and every edge until the next flash is due, count as extra edges: stray light
// makes an image, too. Edges before the first flash, or more than a shortest interval after the last, are
// ignored. Either sensor may see either lamp, so that the lamps do not matter here. Real-time safe; no
// allocation beyond the record's capacity.
#pragma once

#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

class EdgeAssignment {
 public:
  /// A window begins this much before the flash was issued: more than the error of a configured sensor delay.
  static constexpr Duration kEarly = microseconds(20);

  /// shortest: the shortest interval between two flashes of the train.
  void open(ShotRecord& record, Duration shortest) noexcept;
  /// Adds a planned flash; call it in order of time.
  void plan(MonoTime commanded, Lamps lamps = Lamps::both) noexcept;
  void issued(std::int32_t flash_index, MonoTime start, MonoTime end) noexcept;
  /// seen: the edge's stamp less the sensor's delay.
  void edge(Input sensor, MonoTime seen) noexcept;

 private:
  FlashRecord* latest_begun_by(MonoTime seen) noexcept;
  Duration until_next(const FlashRecord& flash) const noexcept;

  ShotRecord* record_ = nullptr;
  Duration shortest_{};
};

}  // namespace strobe::firmware
