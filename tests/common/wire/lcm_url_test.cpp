#include "common/wire/lcm_url.hpp"

#include <rapidcheck.h>

#include <string>
#include <vector>

#include "common/messages/channels.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::wire;

TEST_GROUP(LcmUrl){
    static void accepts(const std::string& text, const LcmUrl& expected){const auto read = read_lcm_url(text);
CHECK_TEXT(read.has_value(), read ? "" : read.error().message.c_str());
CHECK_TEXT(*read == expected, to_text(*read).c_str());
STRCMP_EQUAL("", lcm_url_problem(text).c_str());
}
static void refuses(const std::string& text, const char* because) {
  const auto read = read_lcm_url(text);
  CHECK_FALSE_TEXT(read.has_value(), text.c_str());
  STRCMP_CONTAINS(because, read.error().message.c_str());
  CHECK_TEXT(read.error().message.find('\n') == std::string::npos, read.error().message.c_str());
  STRCMP_EQUAL(read.error().message.c_str(), lcm_url_problem(text).c_str());
}
}
;

TEST(LcmUrl, NamesGroupPortTimeToLiveAndBuffer) {
  accepts(strobe::messages::kDefaultLcmUrl, {{"239.255.76.67", 7667, 2'097'152}, 0});
  accepts("udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152", {{"239.255.76.67", 7667, 2'097'152}, 1});
  accepts("udpm://239.255.76.67:7667?recv_buf_size=1&ttl=255", {{"239.255.76.67", 7667, 1}, 255});
  accepts("udpm://224.0.0.0:1", {{"224.0.0.0", 1, 0}, 0});
  accepts("udpm://239.255.255.255:65535?ttl=0", {{"239.255.255.255", 65535, 0}, 0});
  accepts("udpm://239.1.2.3:7?recv_buf_size=1073741824", {{"239.1.2.3", 7, 1 << 30}, 0});
}

TEST(LcmUrl, MeansLcmsOwnGroupWhereItNamesNone) {
  accepts("udpm://", {{"239.255.76.67", 7667, 0}, 0});
  accepts("udpm://?ttl=1", {{"239.255.76.67", 7667, 0}, 1});
}

TEST(LcmUrl, IsRefusedIfItIsOfAnotherKind) {
  for (const char* url : {"", " ", "memq://", "tcpq://127.0.0.1:7700", "file:///tmp/x.log", "udpm:/", "udpm",
                          " udpm://239.1.2.3:1", "UDPM://239.1.2.3:1", "239.1.2.3:7667"})
    refuses(url, "does not begin with udpm://");
}

TEST(LcmUrl, IsRefusedIfItsPortIsNotAPlainNumber) {
  for (const char* url : {"udpm://239.1.2.3", "udpm://239.1.2.3?ttl=0"}) refuses(url, "it has no port");
  for (const char* port : {"", "0", "65536", "x", "0x1df3", " 7667", "7667 ", "+7667", "-1", "07667", "7667/",
                           "7667:1", "7667&ttl=0", "76 67", "7667\n", "99999999999999999999"})
    refuses(std::string("udpm://239.1.2.3:") + port, "its port is not a number");
}

TEST(LcmUrl, IsRefusedIfItsAddressIsNotAMulticastGroup) {
  for (const char* address : {"", "localhost", "127.0.0.1", "223.255.255.255", "240.0.0.0", "239.1.2",
                              "239.1.2.3.4", "239.1.2.256", "239.1.2.03", "239.1.2.", "239..2.3",
                              "0xef.1.2.3", "239.1.515", " 239.1.2.3", "239.1.2.3 ", "[ff02::1]"})
    refuses("udpm://" + std::string(address) + ":7667", "its address is not one from");
}

TEST(LcmUrl, IsRefusedIfAParameterIsUnknownMalformedOrThereTwice) {
  const std::string group = "udpm://239.1.2.3:7667?";
  for (const char* unknown : {"", "&", "ttl=0&", "&ttl=0", "TTL=0", "ttl =0", "recv_buf=1", "ttl=0?ttl=0 ",
                              "=1", "transmit_only=true"})
    CHECK_FALSE_TEXT(read_lcm_url(group + unknown).has_value(), unknown);
  for (const char* ttl : {"", "256", "-1", "-0", "+1", "0x1", "01", " 1", "1 ", "1=1", "99999999999"})
    refuses(group + "ttl=" + ttl, "its ttl is not a number from 0 to 255");
  refuses(group + "ttl", "its ttl is not");
  for (const char* size : {"", "0", "-1", "1k", "1073741825", "0x10", " 5"})
    refuses(group + "recv_buf_size=" + size, "its recv_buf_size is not");
  refuses(group + "ttl=0&ttl=0", "twice");
  refuses(group + "recv_buf_size=1&ttl=0&recv_buf_size=1", "twice");
}

TEST(LcmUrl, IsQuotedInAnErrorAsOneLineOfBoundedLength) {
  refuses("udpm://239.1.2.3:7667\n?ttl=0", "239.1.2.3:7667??ttl=0");
  CHECK(lcm_url_problem("udpm://" + std::string(100'000, 'x')).size() < 300);
  refuses(std::string("udpm://239.1.2.3:7667\0", 22), "port");
}

TEST(LcmUrl, IsReadTheSameFromItsOwnText) {
  CHECK_TRUE(rc::check([] {
    const auto octet = [] { return std::to_string(*rc::gen::inRange(0, 256)); };
    const LcmUrl url{
        {std::to_string(*rc::gen::inRange(224, 240)) + "." + octet() + "." + octet() + "." + octet(),
         static_cast<std::uint16_t>(*rc::gen::inRange(1, 65536)),
         *rc::gen::inRange(0, kMaxReceiveBuffer_bytes)},
        *rc::gen::inRange(0, 256)};
    const auto read = read_lcm_url(to_text(url));
    RC_ASSERT(read.has_value());
    RC_ASSERT(*read == url);
  }));
}
