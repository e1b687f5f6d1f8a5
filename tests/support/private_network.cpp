#include "tests/support/private_network.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

namespace strobe::testing {
namespace {

std::string because(const std::string& what) { return what + ": " + std::strerror(errno); }

bool write_line(const char* path, const std::string& line) {
  std::ofstream stream(path);
  stream << line;
  return static_cast<bool>(stream.flush());
}

sockaddr address(const char* text) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  inet_pton(AF_INET, text, &in.sin_addr);
  sockaddr plain{};
  static_assert(sizeof in == sizeof plain);
  std::memcpy(&plain, &in, sizeof in);
  return plain;
}

std::string bring_up_loopback(int socket) {
  ifreq interface {};
  std::strncpy(interface.ifr_name, "lo", sizeof interface.ifr_name - 1);
  interface.ifr_flags = IFF_UP | IFF_RUNNING | IFF_MULTICAST;
  if (ioctl(socket, SIOCSIFFLAGS, &interface) != 0) return because("loopback cannot be brought up");
  char device[] = "lo";
  rtentry route{};
  route.rt_dst = address("224.0.0.0");
  route.rt_genmask = address("240.0.0.0");
  route.rt_flags = RTF_UP;
  route.rt_dev = device;
  if (ioctl(socket, SIOCADDRT, &route) != 0 && errno != EEXIST) return because("no route for multicast");
  return {};
}

std::string unshare_network() {
  if (unshare(CLONE_NEWNET) == 0) return {};  // root keeps its rights, real-time ones among them
  const std::string user = std::to_string(geteuid()), group = std::to_string(getegid());
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return because("no network namespace");
  if (!write_line("/proc/self/setgroups", "deny") || !write_line("/proc/self/uid_map", "0 " + user + " 1") ||
      !write_line("/proc/self/gid_map", "0 " + group + " 1"))
    return because("no user namespace");
  return {};
}

}  // namespace

std::string enter_private_network() {
  std::string problem = unshare_network();
  if (!problem.empty()) return problem;
  const int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (control < 0) return because("no socket");
  problem = bring_up_loopback(control);
  close(control);
  return problem;
}

IsolatedEnvironment::IsolatedEnvironment() {
  // Without a namespace each bench still has a multicast group and port drawn at random.
  if (const std::string problem = enter_private_network(); !problem.empty())
    std::fprintf(stderr, "no private network (%s), going on in this one\n", problem.c_str());
  setenv("XDG_CONFIG_HOME", configuration_.path().c_str(), 1);
}

std::string private_lcm_url() {
  std::random_device random;
  const auto draw = [&random](int from, int to) {
    return std::uniform_int_distribution<int>(from, to)(random);
  };
  return "udpm://239.255." + std::to_string(draw(1, 254)) + "." + std::to_string(draw(1, 254)) + ":" +
         std::to_string(draw(20000, 60000)) + "?ttl=0&recv_buf_size=2097152";
}

}  // namespace strobe::testing
