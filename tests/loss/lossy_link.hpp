// A lossy link between two LCM networks: datagrams of one multicast group are sent on to another, each way,
// as they are, but for those that are lost, doubled, delayed or cut off. A thread of its own; all calls from
// any thread. Deterministic in its decisions from a seed and the order in which datagrams come.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace strobe::loss {

struct LinkFaults {
  double loss = 0.0;         ///< probability, each way
  double duplication = 0.0;  ///< of a datagram that is not lost
  double reordering = 0.0;   ///< probability to be delayed by up to max_delay_ms
  int max_delay_ms = 60;
};

struct LinkCounts {
  std::int64_t came = 0, lost = 0, doubled = 0, delayed = 0;
  std::int64_t cut = 0;  ///< came while the link was cut
};

class LossyLink {
 public:
  /// Two URLs "udpm://GROUP:PORT?..." of different groups and ports. std::runtime_error: no multicast.
  LossyLink(const std::string& url_a, const std::string& url_b, const LinkFaults& faults, std::uint64_t seed);
  LossyLink(const LossyLink&) = delete;
  LossyLink& operator=(const LossyLink&) = delete;
  ~LossyLink();

  void cut(bool is_cut);
  LinkCounts counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace strobe::loss
