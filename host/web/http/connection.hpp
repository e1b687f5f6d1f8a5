// One viewer's connection: requests and answers, or the event stream. The network thread's alone.
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <string>

#include "host/web/http/event_hub.hpp"
#include "host/web/http/gate.hpp"
#include "host/web/http/intake.hpp"
#include "host/web/http/page_server.hpp"
#include "host/web/http/worker.hpp"

namespace strobe::web {

class Connection;

/// What connections share. It outlives them.
struct Services {
  boost::asio::io_context& io;
  const Gate& gate;
  EventHub& hub;
  Worker &worker, &waiter, &maker;  ///< of work that is slow, that waits, that lasts
  Patience patience;
  std::size_t max_viewers;  ///< of the event stream
  std::size_t viewers = 0;
  std::function<void(Connection&)> on_closed;
};

class Connection final : public std::enable_shared_from_this<Connection> {
 public:
  Connection(boost::asio::ip::tcp::socket socket, Services& services);

  void start();
  /// The hub may have something new.
  void send_events();
  /// Something is sent to a viewer of the event stream who gets nothing else: that he is gone is then
  /// noticed.
  void ping();
  void close();

  bool streams() const { return streaming_; }
  /// Whether everything of the event stream has been handed to the system.
  bool up_to_date() const { return !writing_ && seen_ == services_.hub.last_id(); }
  /// A request of it was admitted.
  bool trusted() const { return trusted_; }
  const std::string& address() const { return address_; }

 private:
  using Self = std::shared_ptr<Connection>;

  void read();
  void go_on();
  void on_head();
  void on_request();
  void work(Worker& worker);
  void respond(const Response& response, bool keep_alive);
  void write(std::string head, std::shared_ptr<const std::string> body, bool keep_alive);
  void written(bool keep_alive);
  void linger();
  void stream();
  void write_events(std::string text);
  void set_deadline(std::chrono::milliseconds patience);
  void clear_deadline();

  boost::asio::ip::tcp::socket socket_;
  Services& services_;
  boost::asio::steady_timer deadline_;
  std::string address_;
  Intake intake_;
  std::array<char, 8192> received_{};
  std::optional<Admitted> admitted_;
  std::string known_;  ///< If-None-Match
  std::string head_;   ///< being written
  std::shared_ptr<const std::string> body_;
  bool trusted_ = false, answered_ = false, streaming_ = false, writing_ = false, closed_ = false;
  std::int64_t seen_ = 0;
  std::size_t discarded_ = 0;
};

}  // namespace strobe::web
