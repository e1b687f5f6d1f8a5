#include "firmware/publisher/command_feed.hpp"

#include <poll.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/wire/channel_socket.hpp"

namespace strobe::firmware {

namespace {

constexpr int kTurn_ms = 100;
constexpr int kDatagramsAtOnce = 256;  // between two looks at the clock and at the wish to stop

class UdpFeed final : public CommandFeed {
 public:
  UdpFeed(wire::ChannelSocket socket, std::string channel)
      : socket_(std::move(socket)), channel_(std::move(channel)) {}

  void run(const std::stop_token& stop, const Handlers& handlers) override {
    while (!stop.stop_requested()) {
      pollfd readable{socket_.fd(), POLLIN, 0};
      if (poll(&readable, 1, kTurn_ms) < 0 && errno != EINTR)
        throw std::runtime_error(std::string("commands cannot be received any more: ") +
                                 std::strerror(errno));
      for (int i = 0; i < kDatagramsAtOnce && take_one(handlers); ++i) {
      }
      socket_.stay_joined();
      handlers.turn();
    }
  }

 private:
  /// False: none is waiting.
  bool take_one(const Handlers& handlers) {
    const auto received = socket_.receive();
    if (!received) return false;
    const auto datagram = wire::read_datagram(received->bytes);
    if (!datagram || datagram->channel != channel_) return true;
    // A command always fits one datagram.
    if (datagram->parts > 1) {
      handlers.oversized();
    } else {
      handlers.message(datagram->data);
    }
    return true;
  }

  wire::ChannelSocket socket_;
  std::string channel_;
};

}  // namespace

Result<std::unique_ptr<CommandFeed>> CommandFeed::open(const std::string& url, const std::string& channel) {
  const auto read = wire::read_lcm_url(url);
  if (!read) return tl::unexpected(read.error());
  auto socket = wire::ChannelSocket::open(read->group, {channel, true, ""});
  if (!socket) return tl::unexpected(socket.error());
  return std::make_unique<UdpFeed>(std::move(*socket), channel);
}

}  // namespace strobe::firmware
