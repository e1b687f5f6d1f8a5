// A lossy link between two LCM networks: datagrams of one multicast group are sent on to another, each way,
// as they are, but for those that are lost, doubled, delayed or cut off. A thread of its own; all calls from
// any thread. Deterministic in its decisions from a seed and the order in which datagrams come.
#pragma once

#include <netinet/in.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "common/wire/channel_socket.hpp"
#include "tests/campaigns/campaign.hpp"

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

  void cut(bool is_cut) { cut_ = is_cut; }
  LinkCounts counts() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Datagram = std::vector<std::uint8_t>;
  struct Network {
    explicit Network(const std::string& url);
    wire::ChannelSocket ear;
    sockaddr_in group{};
  };
  struct Late {
    const Network* to;
    Datagram datagram;
  };

  void run(const std::stop_token& stop);
  void forward(Network& from, const Network& to);
  void pass(const Network& to, const Datagram& datagram);
  void send(const Network& to, const Datagram& datagram) const;
  bool chance(double probability) { return std::bernoulli_distribution(probability)(random_); }

  Network a_, b_;
  int mouth_;          ///< speaks to both
  sockaddr_in own_{};  ///< its address
  LinkFaults faults_;
  std::mt19937_64 random_;
  std::atomic<bool> cut_{false};
  mutable std::mutex mutex_;
  LinkCounts counts_;
  std::multimap<Clock::time_point, Late> late_;
  std::jthread thread_;
};

// The shipped programs on a simulated bench, the host across a link that loses, or killed at random instants
// of a shot, or the firmware killed: and what both sides' folders hold in the end. Real time; one thread.

enum class Victim { nobody, host, firmware };

struct Trial {
  std::string name{};  ///< its row in the table
  Victim victim = Victim::nobody;
  LinkFaults faults{};
  double cut_s = 0.0;  ///< the link is cut for so long, from an instant of the first shot on; 0: never
  int shots = 1;       ///< that must count, where nobody is killed
  int kills = 0;  ///< one in each shot, at an instant drawn from the shutter's opening to after the readout
  bool full_exposure = false;  ///< else a third of the flashes
};

/// Counts what the audit does, "kills" and what became of "packets".
campaigns::Verdict run_trial(const Trial& trial, campaigns::Draws& draws);

/// Of which kinds a campaign is. Neither links nor kills: both, with a hundred kills of each side.
struct Choice {
  bool links = false;
  int shots = 3, kills = 0;
  double kill_loss = 0.0;
  bool full_exposure = false;
};

/// The trials of a choice in turns: each link, the host killed, strobed killed.
Trial drawn(const Choice& choice, const campaigns::Draws& draws);

}  // namespace strobe::loss
