// What the simulated camera answers to a host's operations, without a network (ISO 15740:2013, clause 10).
// One thread at a time.
#pragma once

#include "sim/ptp/card.hpp"
#include "sim/ptp/packets.hpp"
#include "sim/ptp/properties.hpp"

namespace strobe::sim::ptp {

class Responder {
 public:
  /// Properties and card must outlive it.
  Responder(std::string serial, Properties& properties, Card& card)
      : serial_(std::move(serial)), properties_(properties), card_(card) {}

  Answer answer(const OperationRequest& request);
  /// The host is gone, and its session with it.
  void end_session() { session_ = false; }
  /// Whether a host has asked for a picture since the last call.
  bool take_capture();

 private:
  Answer in_session(const OperationRequest& request);
  Answer of_objects(const OperationRequest& request);
  Answer device_info() const;

  std::string serial_;
  Properties& properties_;
  Card& card_;
  bool session_ = false, capture_ = false;
};

}  // namespace strobe::sim::ptp
