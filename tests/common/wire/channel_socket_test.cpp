// Which datagrams the kernel's filter lets through. Sent by multicast to the test itself.
#include "common/wire/channel_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/private_network.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::wire;

namespace {

/// A stranger's or a host's socket.
class Sender {
 public:
  explicit Sender(const MulticastGroup& group) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(group.port);
    inet_pton(AF_INET, group.address.c_str(), &to_.sin_addr);
  }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  ~Sender() { close(fd_); }
  void send(const std::string& datagram) const {
    const auto sent =
        sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
    LONGS_EQUAL(datagram.size(), sent);
  }

 private:
  int fd_;
  sockaddr_in to_{};
};

std::string whole(const std::string& channel, const std::string& data) {
  return std::string("LC02\0\0\0\7", 8) + channel + std::string(1, '\0') + data;
}

/// The first part says the channel, a later one does not.
std::string part(char number, const std::string& text) {
  return std::string("LC03\0\0\0\7\0\0\1\0\0\0\0\0\0", 17) + number + std::string("\0\3", 2) + text;
}
std::string first_part(const std::string& channel, const std::string& data) {
  return part(0, channel + std::string(1, '\0') + data);
}

int buffer_bytes(int fd) {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, &size);
  return bytes;
}

/// Channels of four lengths that follow each other: the filter compares four bytes at a time, then two, then one.
std::vector<std::string> channels(const std::string& kind) {
  std::vector<std::string> names;
  for (const char* rig : {"b", "be", "ben", "benc"})
    names.push_back("STROBE/" + std::string(rig) + "/" + kind);
  return names;
}

}  // namespace

TEST_GROUP(ChannelSocket) {
  MulticastGroup group;

  void setup() override {
    [[maybe_unused]] static const std::string problem = strobe::testing::enter_private_network();
    group = read_lcm_url(strobe::testing::private_lcm_url())->group;
  }

  static std::string next(ChannelSocket & socket) {
    pollfd readable{socket.fd(), POLLIN, 0};
    LONGS_EQUAL(1, poll(&readable, 1, 10000));  // `end` below comes for certain
    const auto received = socket.receive();
    return {received->bytes.begin(), received->bytes.end()};
  }
  /// The last characters of the datagrams that are let through.
  std::string passed(const ChannelChoice& choice, const std::vector<std::string>& datagrams) const {
    auto socket = ChannelSocket::open(group, choice);
    CHECK_TRUE(socket.has_value());
    const Sender sender(group);
    for (const std::string& datagram : datagrams) sender.send(datagram);
    const std::string end = whole(choice.wanted, std::string(40, '.'));  // as long as any message
    sender.send(end);
    std::string passed;
    for (std::string datagram; datagram != end;) {
      datagram = next(*socket);
      CHECK_TRUE(datagram == end || std::ranges::count(datagrams, datagram) > 0);
      passed += datagram.back();
    }
    return passed;
  }
};

TEST(ChannelSocket, LetsAWholeChannelThroughAndNoOther) {
  for (const std::string& wanted : channels("COMMAND")) {
    std::vector<std::string> datagrams{whole(wanted, "1"),
                                       first_part(wanted, "2"),
                                       part(1, "x"),
                                       "LC01" + whole(wanted, "x").substr(4),
                                       "LC0",
                                       part(0, "").substr(0, 19)};
    for (std::size_t at = 0; at <= wanted.size(); ++at) {
      std::string other = wanted + "S";
      if (at < wanted.size()) other = wanted, other[at] ^= 1;
      datagrams.insert(datagrams.end(),
                       {whole(other, "x"), first_part(other, "x"), whole(wanted.substr(0, at), "x")});
    }
    datagrams.pop_back();  // the channel itself
    CHECK_EQUAL("12.", passed({wanted, true, ""}, datagrams));
  }
}

TEST(ChannelSocket, LetsChannelsOfOneBeginningThroughButTheOneThatIsUnwanted) {
  for (const std::string& unwanted : channels("COMMAND")) {
    const std::string beginning = unwanted.substr(0, unwanted.size() - 7);
    // A later part does not say whose it is.
    std::vector<std::string> datagrams{whole(beginning + "EVENT", "1"),
                                       first_part(beginning + "EVENT", "2"),
                                       part(1, "3"),
                                       whole(unwanted, "x"),
                                       first_part(unwanted, "x"),
                                       whole(unwanted + "S", "4")};
    for (std::size_t at = 0; at < beginning.size(); ++at) {
      std::string other = unwanted;
      other[at] ^= 1;
      datagrams.insert(datagrams.end(), {whole(other, "x"), first_part(other, "x")});
    }
    CHECK_EQUAL("1234.", passed({beginning, false, unwanted}, datagrams));
  }
}

TEST(ChannelSocket, TellsTheSenderAndWhenNothingIsWaiting) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  auto beside = ChannelSocket::open(group, {"X", true, ""});  // on the same port
  CHECK_FALSE(socket->receive().has_value());
  const Sender one(group), two(group);
  std::vector<std::uint64_t> senders;
  for (const Sender* sender : {&one, &two, &one}) {
    sender->send(whole("X", "data"));
    pollfd readable{socket->fd(), POLLIN, 0};
    poll(&readable, 1, 10000);
    senders.push_back(socket->receive()->sender);
    CHECK_EQUAL(whole("X", "data"), next(*beside));
  }
  CHECK_TRUE(senders[0] == senders[2] && senders[0] != senders[1]);
}

TEST(ChannelSocket, HasTheBufferThatIsAskedFor) {
  group.receive_buffer_bytes = 0;
  const int usual = buffer_bytes(ChannelSocket::open(group, {"X", true, ""})->fd());
  CHECK_TRUE(usual > 50'000);
  group.receive_buffer_bytes = 20'000;
  LONGS_EQUAL(40'000,
              buffer_bytes(ChannelSocket::open(group, {"X", true, ""})->fd()));  // the kernel doubles it
}

TEST(ChannelSocket, SaysWhyNothingCanBeReceived) {
  group.address = "239.255.1";
  STRCMP_CONTAINS("address: ", ChannelSocket::open(group, {"X", true, ""}).error().message.c_str());
  group.address = "127.0.0.1";
  STRCMP_CONTAINS("joining the group: ", ChannelSocket::open(group, {"X", true, ""}).error().message.c_str());
  group.address = "192.0.2.1";  // of documentation: nobody's
  STRCMP_CONTAINS(("192.0.2.1:" + std::to_string(group.port) + ": bind: ").c_str(),
                  ChannelSocket::open(group, {"X", true, ""}).error().message.c_str());
}
