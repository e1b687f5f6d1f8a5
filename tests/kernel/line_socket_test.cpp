#include "tests/kernel/line_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::kernel;
using namespace std::chrono_literals;

TEST_GROUP(LineSocket) {
  strobe::testing::TemporaryFolder folder;
  LineSocket ours{folder.path() / "line"};
  int theirs = -1;

  void setup() override {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, (folder.path() / "line").c_str());
    theirs = socket(AF_UNIX, SOCK_STREAM, 0);
    LONGS_EQUAL(0, connect(theirs, reinterpret_cast<const sockaddr*>(&address), sizeof address));
    ours.accept(1s);
  }
  void teardown() override {
    if (theirs >= 0) close(theirs);
  }
  void say(const std::string& text) { LONGS_EQUAL(text.size(), write(theirs, text.data(), text.size())); }
};

TEST(LineSocket, GivesWholeLinesWhateverThePiecesTheyCameIn) {
  say("one\r\ntw");
  STRCMP_EQUAL("one", ours.receive(1s)->c_str());
  CHECK_FALSE(ours.receive(0ms).has_value());
  say("o\n\nthree\n");
  STRCMP_EQUAL("two", ours.receive(1s)->c_str());
  STRCMP_EQUAL("", ours.receive(1s)->c_str());
  STRCMP_EQUAL("three", ours.receive(1s)->c_str());
}

TEST(LineSocket, SendsWhatItIsGiven) {
  ours.send("abc");
  char got[8] = {};
  LONGS_EQUAL(3, read(theirs, got, sizeof got));
  STRCMP_EQUAL("abc", got);
}

TEST(LineSocket, SaysWhenTheOtherSideIsGone) {
  say("last\n");
  close(theirs);
  theirs = -1;
  STRCMP_EQUAL("last", ours.receive(1s)->c_str());
  CHECK_THROWS(PeerGone, ours.receive(1s));
  CHECK_THROWS(PeerGone, ours.send("abc"));
}

TEST(LineSocket, SaysTheSameWhenTheOtherSideHadNotReadAll) {
  ours.send("unread");
  close(theirs);
  theirs = -1;
  CHECK_THROWS(PeerGone, ours.receive(1s));
}
