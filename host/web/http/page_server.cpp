#include "host/web/http/page_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <regex>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "host/web/http/connection.hpp"

namespace strobe::web {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;

constexpr std::chrono::milliseconds kPing{15000};
constexpr std::chrono::milliseconds kMaxFarewell{200}, kFarewellStep{5};
constexpr std::chrono::milliseconds kNoDescriptors{100};

/// Programs that the host starts have no business with them.
void close_on_exec(int descriptor) { fcntl(descriptor, F_SETFD, FD_CLOEXEC); }

std::string machine_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

AccessSettings access_settings(const net::ip::address& address, std::uint16_t port, std::string secret) {
  return {address.is_loopback(), machine_name(), std::move(secret), port};
}

tl::unexpected<Error> cannot(const ListenAddress& where, const std::string& why) {
  const char* const colons = where.address.find(':') == std::string::npos ? "{}:{}: {}" : "[{}]:{}: {}";
  return fail(fmt::format(fmt::runtime(colons), where.address, where.port, why));
}

}  // namespace

class PageServer::Implementation {
 public:
  Implementation(const ServerSettings& settings, const tcp::endpoint& wanted, std::string secret,
                 const Router& router, EventHub& hub)
      : acceptor_(io_, wanted),
        endpoint_(acceptor_.local_endpoint()),
        secret_(std::move(secret)),
        gate_(Access(access_settings(endpoint_.address(), endpoint_.port(), secret_)), router),
        hub_(hub),
        worker_(settings.limits.slow_requests),
        waiter_(settings.limits.slow_requests),
        maker_(settings.limits.slow_requests),
        services_{io_,
                  gate_,
                  hub,
                  worker_,
                  waiter_,
                  maker_,
                  settings.limits.patience,
                  settings.limits.viewers,
                  0,
                  [this](Connection& closed) { forget(closed); }},
        max_connections_(settings.limits.connections),
        ping_(io_),
        pause_(io_) {
    close_on_exec(acceptor_.native_handle());
    accept();
    ping_after_a_while();
    hub_.set_wake([this] { wake(); });
    thread_ = background_thread("strobe-web", [this] { run(); });
  }

  bool end() {
    if (!thread_.joinable()) return work_ended_;
    for (Worker* worker : {&waiter_, &worker_, &maker_}) work_ended_ = worker->end() && work_ended_;
    hub_.publish("end", "{}");
    net::post(io_, [this] {
      error_code error;
      acceptor_.close(error);
      pause_.cancel();
      part(kMaxFarewell / kFarewellStep);
    });
    thread_.join();
    hub_.set_wake({});
    return work_ended_;
  }

  const tcp::endpoint& endpoint() const { return endpoint_; }
  const std::string& secret() const { return secret_; }

 private:
  void run() {
    while (!io_.stopped()) {
      try {
        io_.run();
      } catch (const std::exception&) {  // such as memory that was not to be had: of one connection
      }
    }
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (!error) {
        close_on_exec(socket.native_handle());
        add(std::move(socket));
      }
      if (error == error_code(EMFILE, boost::system::system_category()) ||
          error == error_code(ENFILE, boost::system::system_category()))
        return accept_later();
      accept();
    });
  }

  void accept_later() {
    pause_.expires_after(kNoDescriptors);
    pause_.async_wait([this](error_code error) {
      if (!error) accept();
    });
  }

  void add(tcp::socket socket) {
    if (connections_.size() >= max_connections_ && !make_room()) {
      error_code ignored;
      socket.non_blocking(true, ignored);
      const std::string_view answer = overload_answer();
      socket.write_some(net::buffer(answer), ignored);
      return;
    }
    connections_.push_back(std::make_shared<Connection>(std::move(socket), services_));
    connections_.back()->start();
  }

  /// Closes the oldest connection that has shown no right to ask.
  bool make_room() {
    const auto stranger =
        std::ranges::find_if(connections_, [](const auto& connection) { return !connection->trusted(); });
    if (stranger == connections_.end()) return false;
    const auto closed = *stranger;
    closed->close();
    return true;
  }

  void forget(const Connection& closed) {
    std::erase_if(connections_, [&closed](const auto& connection) { return connection.get() == &closed; });
  }

  void for_each_viewer(void (Connection::*act)()) {
    const auto connections = connections_;  // which closing changes
    for (const auto& connection : connections) {
      if (connection->streams()) (connection.get()->*act)();
    }
  }

  /// On a publisher's thread.
  void wake() {
    if (!woken_.exchange(true)) {
      net::post(io_, [this] {
        woken_ = false;
        for_each_viewer(&Connection::send_events);
      });
    }
  }

  void ping_after_a_while() {
    ping_.expires_after(kPing);
    ping_.async_wait([this](error_code error) {
      if (error) return;
      for_each_viewer(&Connection::ping);
      ping_after_a_while();
    });
  }

  /// Waits until the viewers have been told, if they read.
  void part(long steps_left) {
    for_each_viewer(&Connection::send_events);
    const bool told = std::ranges::all_of(connections_, [](const auto& connection) {
      return !connection->streams() || connection->up_to_date();
    });
    if (told || steps_left <= 0) return close_all();
    pause_.expires_after(kFarewellStep);
    pause_.async_wait([this, steps_left](error_code) { part(steps_left - 1); });
  }

  void close_all() {
    const auto connections = connections_;
    for (const auto& connection : connections) connection->close();
    ping_.cancel();
    io_.stop();
  }

  net::io_context io_{1};
  tcp::acceptor acceptor_;
  tcp::endpoint endpoint_;
  std::string secret_;
  Gate gate_;
  EventHub& hub_;
  Worker worker_, waiter_, maker_;
  Services services_;
  std::size_t max_connections_;
  std::vector<std::shared_ptr<Connection>> connections_;  // the oldest first
  net::steady_timer ping_, pause_;
  std::atomic<bool> woken_{false};
  bool work_ended_ = true;
  std::thread thread_;
};

Result<ListenAddress> parse_listen_address(std::string_view text) {
  const auto wrong = [text] {
    return fail(fmt::format("\"{}\" is not ADDRESS:PORT, such as 127.0.0.1:8650 or [::1]:8650", text));
  };
  if (text.empty()) return ListenAddress{};
  static const std::regex kForm(R"((?:\[(.*)\]|(localhost|[0-9]+\.[0-9.]+))?(:?)([0-9]{1,5})?)");
  std::cmatch match;
  if (!std::regex_match(text.data(), text.data() + text.size(), match, kForm)) return wrong();
  const bool has_address = match[1].matched || match[2].matched, has_port = match[4].matched;
  if ((match[3].length() > 0) != (has_address && has_port)) return wrong();
  ListenAddress where;
  if (has_address) {
    in6_addr address{};
    where.address = match[1].matched          ? match[1].str()
                    : match[2] == "localhost" ? "127.0.0.1"
                                              : match[2].str();
    if (inet_pton(match[1].matched ? AF_INET6 : AF_INET, where.address.c_str(), &address) != 1)
      return wrong();
  }
  if (has_port && std::stoul(match[4]) > 65535) return wrong();
  if (has_port) where.port = static_cast<std::uint16_t>(std::stoul(match[4]));
  return where;
}

Result<std::unique_ptr<PageServer>> PageServer::open(const ServerSettings& settings, const Router& router,
                                                     EventHub& hub) try {
  error_code error;
  const auto address = net::ip::make_address(settings.where.address, error);
  if (error) return cannot(settings.where, "not an address in figures, such as 127.0.0.1");
  std::string secret = address.is_loopback() ? "" : random_secret();
  if (!address.is_loopback() && secret.empty()) return cannot(settings.where, "libsodium cannot be started");
  return std::unique_ptr<PageServer>(new PageServer(std::make_unique<Implementation>(
      settings, tcp::endpoint(address, settings.where.port), std::move(secret), router, hub)));
} catch (const boost::system::system_error& error) {
  return cannot(settings.where, error.code().message());
}

PageServer::PageServer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}

PageServer::~PageServer() { end(); }

bool PageServer::end() {
  if (!implementation_) return false;
  if (implementation_->end()) return true;
  static_cast<void>(implementation_.release());  // the job under way will hand its answer to it
  return false;
}

std::uint16_t PageServer::port() const { return implementation_->endpoint().port(); }

const std::string& PageServer::secret() const { return implementation_->secret(); }

std::string PageServer::url() const {
  const auto address = implementation_->endpoint().address();
  std::string host = address.is_unspecified() ? machine_name() : address.to_string();
  if (address.is_v6() && !address.is_unspecified()) host = "[" + host + "]";
  return fmt::format("http://{}:{}/", host, port());
}

std::string PageServer::url_with_secret() const {
  return secret().empty() ? url() : url() + "?secret=" + secret();
}

}  // namespace strobe::web
