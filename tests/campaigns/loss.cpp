#include "tests/campaigns/loss.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <stdexcept>

#include "tests/campaigns/audit.hpp"
#include "tests/campaigns/series_lab.hpp"
#include "tests/support/private_network.hpp"

namespace strobe::loss {

namespace {

using campaigns::Draws;
using campaigns::Verdict;
using testing::ExitStatus;
using testing::Process;

/// A bench, and hosts on another network that is joined with it by a relay.
class Lab : campaigns::SeriesLab {
 public:
  Lab(const Trial& trial, Draws& draws)
      : SeriesLab(campaigns::series_rig(draws, trial.victim != Victim::nobody, trial.full_exposure), draws),
        trial_(trial),
        relay_(rig_.lcm_url(), host_url_, trial.faults, draws.seed()) {}

  Verdict run() {
    const std::int64_t start_ns = testing::monotonic_now_ns();
    const bool ended = trial_.victim == Victim::nobody ? lose()
                       : trial_.victim == Victim::host ? kill_hosts()
                                                       : kill_firmwares();
    take_down();  // so that every shot has its end
    Verdict verdict = audit(rig_.session(), host_folder());
    if (!ended) verdict.violate("the series did not end as ordered");
    if (verdict.counts["events journalled"] == 0) verdict.violate("the journals have no event");
    verdict.words = verdict_.words;
    verdict.trial = trial_.name;
    verdict.rows = {{"what", trial_.name}};
    count(verdict, static_cast<double>(testing::monotonic_now_ns() - start_ns) * 1e-9);
    return verdict;
  }

 private:
  void count(Verdict& verdict, double duration_s) const {
    const LinkCounts link = relay_.counts();
    verdict.count("kills", kills_);
    verdict.count("packets", static_cast<double>(link.came));
    verdict.count("packets lost", static_cast<double>(link.lost));
    verdict.count("packets cut", static_cast<double>(link.cut));
    verdict.count("packets doubled", static_cast<double>(link.doubled));
    verdict.count("packets delayed", static_cast<double>(link.delayed));
    verdict.count("seconds", duration_s);
  }

  Process fire(int shots, int retries) {
    testing::Command command = rig_.strobe({"fire", "--shots", std::to_string(shots), "--retries",
                                            std::to_string(retries), "--session", host_folder(), "--plain"});
    command.arguments.back() = host_url_;
    return rig_.start(command);
  }
  bool last_series(int shots) {
    Process host = fire(shots, 1000);
    return end_of(host) == ExitStatus({0, 0});
  }

  bool lose() {
    Process host = fire(trial_.shots, 1000);
    if (trial_.cut_s > 0.0 && reach_instant_of_a_shot(host, 300)) {
      relay_.cut(true);
      testing::sleep_for(std::chrono::milliseconds(static_cast<int>(trial_.cut_s * 1e3)));
      relay_.cut(false);
    }
    return end_of(host) == ExitStatus({0, 0});
  }

  /// Each host fires one shot and dies in it; the next one takes over its folder.
  bool kill_hosts() {
    for (; kills_ < trial_.kills; ++kills_) {
      Process host = fire(1, 1000);
      if (!reaches_shot(host)) return false;
      host.signal(SIGKILL);
      host.wait(std::chrono::seconds(5));
    }
    return last_series(1);
  }

  /// The firmware dies in a shot of each host, whose series ends with it; the next one takes over its folder.
  bool kill_firmwares() {
    while (kills_ < trial_.kills) {
      Process host = fire(100'000, 100'000);
      if (!reaches_shot(host)) return false;
      const pid_t worker = rig_.worker(), guardian = rig_.guardian();
      if (worker == 0) continue;
      if (draws_.chance(1.0 / 3.0)) kill(guardian, SIGKILL);
      kill(worker, SIGKILL);
      ++kills_;
      end_of(host);
    }
    return last_series(2);  // what the last death left has then been told and fetched
  }

  bool reaches_shot(Process& host) {
    if (reach_instant_of_a_shot(host, trial_.full_exposure ? 1000 : 600)) return true;
    verdict_.words += "no shot came\n";
    return false;
  }

  const Trial& trial_;
  std::string host_url_ = testing::private_lcm_url();
  LossyLink relay_;
  int kills_ = 0;
};

const std::vector<Trial>& links() {
  constexpr auto kNobody = Victim::nobody;
  static const std::vector<Trial> links{
      {"no loss", kNobody, {}},
      {"5 % loss", kNobody, {0.05, 0, 0, 60}},
      {"20 % loss", kNobody, {0.2, 0, 0, 60}},
      {"50 % loss", kNobody, {0.5, 0, 0, 60}},
      {"20 % doubled", kNobody, {0, 0.2, 0, 60}},
      {"20 % late by up to 60 ms", kNobody, {0, 0, 0.2, 60}},
      {"20 % lost, 10 % doubled, 20 % late", kNobody, {0.2, 0.1, 0.2, 60}},
      {"cut for 10 s in a shot", kNobody, {}, 10},
      {"20 % loss, cut for 10 s", kNobody, {0.2, 0, 0, 60}, 10},
  };
  return links;
}

}  // namespace

Verdict run_trial(const Trial& trial, Draws& draws) { return Lab(trial, draws).run(); }

Trial drawn(const Choice& choice, const Draws& draws) {
  const bool both = !choice.links && choice.kills == 0;
  std::vector<Trial> trials;
  if (choice.links || both) trials = links();
  if (choice.kills > 0 || both) {
    const std::string loss =
        choice.kill_loss > 0 ? fmt::format(", {:.0f} % loss", choice.kill_loss * 100) : "";
    trials.push_back({"the host killed" + loss, Victim::host, {choice.kill_loss}});
    trials.push_back({"strobed killed" + loss, Victim::firmware, {choice.kill_loss}});
  }
  Trial trial = trials[static_cast<std::size_t>(draws.number() - 1) % trials.size()];
  trial.shots = choice.shots;
  trial.kills = both ? 100 : choice.kills;
  trial.full_exposure = choice.full_exposure;
  return trial;
}


namespace {

template <typename T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

wire::MulticastGroup group_of(const std::string& url) { return value_of(wire::read_lcm_url(url)).group; }

}  // namespace

LossyLink::Network::Network(const std::string& url)
    : ear(value_of(wire::ChannelSocket::open(group_of(url), {"", false, ""}))) {
  const int room = 8 << 20;
  setsockopt(ear.fd(), SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
  group.sin_family = AF_INET;
  group.sin_port = htons(group_of(url).port);
  inet_pton(AF_INET, group_of(url).address.c_str(), &group.sin_addr);
}

LossyLink::LossyLink(const std::string& url_a, const std::string& url_b, const LinkFaults& faults,
                     std::uint64_t seed)
    : a_(url_a),
      b_(url_b),
      mouth_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
      faults_(faults),
      random_(seed) {
  own_.sin_family = AF_INET;
  const unsigned char ttl = 0;
  setsockopt(mouth_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  socklen_t size = sizeof own_;
  if (bind(mouth_, reinterpret_cast<const sockaddr*>(&own_), size) != 0 ||
      getsockname(mouth_, reinterpret_cast<sockaddr*>(&own_), &size) != 0)
    throw std::runtime_error("no socket to relay by");
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

LossyLink::~LossyLink() {
  thread_ = {};
  close(mouth_);
}

LinkCounts LossyLink::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LossyLink::run(const std::stop_token& stop) {
  std::array<pollfd, 2> polled{{{a_.ear.fd(), POLLIN, 0}, {b_.ear.fd(), POLLIN, 0}}};
  while (!stop.stop_requested()) {
    poll(polled.data(), polled.size(), late_.empty() ? 50 : 1);
    forward(a_, b_);
    forward(b_, a_);
    while (!late_.empty() && late_.begin()->first <= Clock::now()) {
      send(*late_.begin()->second.to, late_.begin()->second.datagram);
      late_.erase(late_.begin());
    }
  }
}

void LossyLink::forward(Network& from, const Network& to) {
  while (const auto received = from.ear.receive()) {
    // Its port is the lower half of a sender's number.
    if (received->bytes.empty() || static_cast<in_port_t>(received->sender) == own_.sin_port) continue;
    const Datagram datagram(received->bytes.begin(), received->bytes.end());
    const std::lock_guard lock(mutex_);
    ++counts_.came;
    if (cut_) {
      ++counts_.cut;
    } else if (chance(faults_.loss)) {
      ++counts_.lost;
    } else {
      pass(to, datagram);
      if (!chance(faults_.duplication)) continue;
      ++counts_.doubled;
      pass(to, datagram);
    }
  }
}

void LossyLink::pass(const Network& to, const Datagram& datagram) {
  if (!chance(faults_.reordering)) return send(to, datagram);
  ++counts_.delayed;
  const auto delay =
      std::chrono::milliseconds(std::uniform_int_distribution<int>(1, faults_.max_delay_ms)(random_));
  late_.emplace(Clock::now() + delay, Late{&to, datagram});
}

void LossyLink::send(const Network& to, const Datagram& datagram) const {
  sendto(mouth_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to.group),
         sizeof to.group);
}

}  // namespace strobe::loss
