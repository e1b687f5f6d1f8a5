// The network side of the simulated camera: one host at a time, on two TCP connections (PTP/IP, CIPA DC-005,
// clause 3). One thread; never blocks but in wait().
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/ptp/packets.hpp"

namespace strobe::sim::ptp {

class Server {
 public:
  struct Host {
    std::function<Answer(const OperationRequest&)> answer;
    std::function<void()> gone;  ///< the host has left
  };
  /// Listens at port 15740 of an IPv4 address. Fails, naming the address.
  static Result<std::unique_ptr<Server>> open(const std::string& address, Host host);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The camera's network is there, or is cut: connections end and nobody listens.
  Result<void> set_reachable(bool reachable);
  /// It takes what comes and answers nothing.
  void set_deaf(bool deaf) { deaf_ = deaf; }

  /// Waits for a host's words or so long, and answers them.
  void wait(const RigClock& clock, Duration longest);
  /// To the host, if one listens.
  void send(const Event& event);

 private:
  struct Connection {
    int fd = -1;
    PacketReader reader{};
    Bytes to_send{};
    std::optional<OperationRequest> awaits_data{};
  };
  Server(std::string address, Host host) : address_(std::move(address)), host_(std::move(host)) {}
  Result<void> listen();
  void accept();
  void receive(Connection& connection);
  void take(Connection& connection, const Packet& packet);
  void take_operation(Connection& connection, const Packet& packet);
  void begin_command(Connection& connection);
  void begin_events(Connection& connection, const Packet& packet);
  void answer(Connection& connection, const OperationRequest& request);
  static void send_what_fits(Connection& connection);
  static void end(Connection& connection);
  void end_all();

  std::string address_;
  Host host_;
  int listening_ = -1;
  Connection command_, events_, fresh_;  ///< fresh: it has not said yet which it is to be
  bool deaf_ = false;
};

}  // namespace strobe::sim::ptp
