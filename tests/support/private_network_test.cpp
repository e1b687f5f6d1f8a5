// Moves the whole test program into a namespace, so it is a program of its own.
#include "tests/support/private_network.hpp"

#include <lcm/lcm-cpp.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include <CppUTest/TestHarness.h>

using namespace strobe::testing;

namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

struct Count {
  int messages = 0;
  void take(const lcm::ReceiveBuffer*, const std::string&) { ++messages; }
};

/// Runs a function in a forked child and returns its exit status.
template <typename Function>
int in_child(Function function) {
  const pid_t child = fork();
  if (child == 0) _exit(function());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// A message to oneself by multicast: the only way to know that LCM works here.
int lcm_round_trip() {
  if (!enter_private_network().empty()) return 77;
  lcm::LCM lcm(kUrl);
  if (!lcm.good()) return 1;
  Count count;
  lcm.subscribe("CHANNEL", &Count::take, &count);
  const std::string text = "text";
  lcm.publish("CHANNEL", text.data(), static_cast<unsigned>(text.size()));
  return lcm.handleTimeout(5000) > 0 && count.messages == 1 ? 0 : 2;
}

}  // namespace

TEST_GROUP(PrivateNetwork){};

TEST(PrivateNetwork, CarriesLcm) {
  const int status = in_child(lcm_round_trip);
  if (status == 77) return;  // a container without namespaces: programs fall back to a private port
  CHECK_EQUAL(0, status);
}

TEST(PrivateNetwork, UrlsDifferFromOneToTheNext) { CHECK(private_lcm_url() != private_lcm_url()); }
