// Which datagrams the kernel's filter lets through, and that the group is heard on interfaces made anew. Sent by
// multicast to the test itself.
#include "common/wire/channel_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/private_network.hpp"
#include "tests/support/process.hpp"

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

namespace {

void ip(const std::string& words) {
  const auto done =
      strobe::testing::run_process({{"sh", "-c", "ip " + words}, {}, {}, {}}, std::chrono::seconds{60});
  CHECK_TEXT(done.status == strobe::testing::ExitStatus({0, 0}), (words + ": " + done.err).c_str());
}

}  // namespace

/// Multicast goes through a virtual Ethernet, which is taken away and made anew.
TEST_GROUP(ChannelSocketOnAnInterface) {
  MulticastGroup group;

  void setup() override {
    static const std::string problem = strobe::testing::enter_private_network();
    CHECK_EQUAL("", problem);
    group = read_lcm_url(strobe::testing::private_lcm_url())->group;
    ip("route del 224.0.0.0/4 dev lo");
    make("first");
  }
  void teardown() override {
    ip("-o link show type veth | sed 's/^[0-9]*: \\([^@]*\\)@.*/\\1/' | while read name; do "
       "ip link del $name 2>/dev/null || true; done");
    ip("route replace 224.0.0.0/4 dev lo");
  }
  static void make(const std::string& name, const std::string& more = "") {
    ip("link add " + name + more + " type veth peer name " + name + "_");
    ip("link set " + name + " up");
    ip("link set " + name + "_ up");
    ip("address add 10.9.8.7/24 dev " + name);
    ip("route replace 224.0.0.0/4 dev " + name);
  }
  static void remove(const std::string& name) { ip("link del " + name); }

  void hears(ChannelSocket & socket) {
    const Sender sender(group);
    const std::string datagram = whole("X", std::to_string(++number_));
    sender.send(datagram);
    for (std::string got; got != datagram;) {
      pollfd readable{socket.fd(), POLLIN, 0};
      LONGS_EQUAL(1, poll(&readable, 1, 10000));
      const auto received = socket.receive();
      got = {received->bytes.begin(), received->bytes.end()};
    }
    CHECK_FALSE(socket.receive().has_value());  // and once
  }
  /// How many sockets have joined it there, as the kernel counts.
  int users(const std::string& name) const {
    in_addr address{};
    inet_pton(AF_INET, group.address.c_str(), &address);
    char wanted[9];
    std::snprintf(wanted, sizeof wanted, "%08X", address.s_addr);
    std::ifstream groups("/proc/net/igmp");
    std::string interface;
    for (std::string line; std::getline(groups, line);) {
      std::istringstream words(line);
      std::string first, second;
      words >> first >> second;
      if (line[0] != '\t') interface = second;
      if (interface == name && first == wanted) return std::stoi(second);
    }
    return 0;
  }

 private:
  int number_ = 0;
};

TEST(ChannelSocketOnAnInterface, HearsTheGroupOnAnInterfaceThatWasMadeAnew) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  hears(*socket);
  remove("first");
  socket->stay_joined();
  make("first");
  socket->stay_joined();
  hears(*socket);
}

TEST(ChannelSocketOnAnInterface, HearsItThoughTheNewOneHasTheIndexOfTheFormer) {
  remove("first");
  make("one", " index 77");
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  hears(*socket);
  remove("one");
  make("one", " index 77");
  socket->stay_joined();
  hears(*socket);
}

TEST(ChannelSocketOnAnInterface, HearsItHoweverOftenItIsMadeAnew) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  for (int i = 0; i < 25; ++i) {  // a socket may have 20 memberships
    remove("first");
    make("first");
    socket->stay_joined();
  }
  hears(*socket);
}

TEST(ChannelSocketOnAnInterface, HearsItOnTheInterfaceThatARouteMovesTo) {
  for (const char* limit : {"20", "1"}) {  // of memberships
    std::ofstream("/proc/sys/net/ipv4/igmp_max_memberships") << limit;
    auto socket = ChannelSocket::open(group, {"X", true, ""});
    make("second");
    socket->stay_joined();
    hears(*socket);
    ip("route replace 224.0.0.0/4 dev first");
    socket->stay_joined();
    hears(*socket);
    remove("second");
  }
  std::ofstream("/proc/sys/net/ipv4/igmp_max_memberships") << 20;
}

TEST(ChannelSocketOnAnInterface, JoinsItOnceAndLeavesItAlone) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  for (int i = 0; i < 10; ++i) {
    ip("address add 10.9.9." + std::to_string(i + 1) + "/24 dev first");
    socket->stay_joined();
    LONGS_EQUAL(1, users("first"));
  }
  hears(*socket);
}

TEST(ChannelSocketOnAnInterface, JoinsItAfterAWhileThoughNobodyTellsThatItCanBe) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  remove("first");
  std::ofstream("/proc/sys/net/ipv4/igmp_max_memberships") << 0;
  make("first");
  socket->stay_joined();
  LONGS_EQUAL(0, users("first"));
  std::ofstream("/proc/sys/net/ipv4/igmp_max_memberships") << 20;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{60};
  while (users("first") == 0 && std::chrono::steady_clock::now() < end) {
    poll(nullptr, 0, 20);
    socket->stay_joined();
  }
  hears(*socket);
}

TEST(ChannelSocketOnAnInterface, TellsASendersAddress) {
  auto socket = ChannelSocket::open(group, {"X", true, ""});
  Sender(group).send(whole("X", "data"));
  pollfd readable{socket->fd(), POLLIN, 0};
  LONGS_EQUAL(1, poll(&readable, 1, 10000));
  CHECK_EQUAL("10.9.8.7", address_of(socket->receive()->sender));
  CHECK_EQUAL("", address_of(0));
}
