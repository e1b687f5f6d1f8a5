#include "host/web/http/listen_address.hpp"

#include "tests/support/string_from.hpp"

using strobe::web::ListenAddress;
using strobe::web::parse_listen_address;

TEST_GROUP(WebListenAddress){static void takes(std::string_view text, const std::string& address,
                                               int port){const auto read = parse_listen_address(text);
CHECK_TEXT(read.has_value(), std::string(text).c_str());
CHECK_EQUAL(address, read->address);
LONGS_EQUAL(port, read->port);
}
}
;

TEST(WebListenAddress, HasADefaultForWhatIsLeftOut) {
  takes("", "127.0.0.1", 8650);
  takes("9000", "127.0.0.1", 9000);
  takes("0", "127.0.0.1", 0);
  takes("192.168.1.7", "192.168.1.7", 8650);
  takes("localhost", "127.0.0.1", 8650);
  takes("[::1]", "::1", 8650);
}

TEST(WebListenAddress, IsAnAddressInFiguresAndAPort) {
  takes("0.0.0.0:80", "0.0.0.0", 80);
  takes("localhost:65535", "127.0.0.1", 65535);
  takes("[fe80::1]:0", "fe80::1", 0);
}

TEST(WebListenAddress, IsRefusedOtherwiseWithWhatWasGiven) {
  for (const char* text :
       {"lab-pc", "lab-pc:80", "65536", "127.0.0.1:65536", "127.0.0.1:", ":8650", "127.0.0.1:+1", "::1",
        "[::1", "[::1]8650", "[1.2.3.4]:1", "1.2.3:4", "-1", " ", "127.0.0.1:1 "}) {
    const auto read = parse_listen_address(text);
    CHECK_TEXT(!read, text);
    STRCMP_CONTAINS(text, read.error().message.c_str());
  }
}
