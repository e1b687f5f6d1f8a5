#include "common/wire/lcm_datagram.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe::wire;
using Bytes = std::vector<std::uint8_t>;

namespace {

constexpr const char* kChannel = "STROBE/bench/COMMAND";

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Bytes whole(std::string_view channel, std::string_view message) {
  Bytes datagram = bytes_of("LC02");
  datagram.insert(datagram.end(), {0, 0, 0, 7});
  datagram.insert(datagram.end(), channel.begin(), channel.end());
  datagram.push_back(0);
  datagram.insert(datagram.end(), message.begin(), message.end());
  return datagram;
}

Bytes part(const Bytes& message_bytes, const Bytes& at, std::uint8_t number, std::uint8_t parts,
           std::string_view data) {
  Bytes datagram = bytes_of("LC03");
  datagram.insert(datagram.end(), {0, 0, 0, 7});
  datagram.insert(datagram.end(), message_bytes.begin(), message_bytes.end());
  datagram.insert(datagram.end(), at.begin(), at.end());
  datagram.insert(datagram.end(), {0, number, 0, parts});
  datagram.insert(datagram.end(), data.begin(), data.end());
  return datagram;
}

}  // namespace

TEST_GROUP(LcmDatagram){};

TEST(LcmDatagram, HoldsAWholeMessage) {
  const Bytes bytes = whole(kChannel, "arm");
  const auto read = read_datagram(bytes);
  CHECK_TRUE(read.has_value());
  CHECK_EQUAL(kChannel, read->channel);
  CHECK_TRUE(std::ranges::equal(read->data, bytes_of("arm")));
  LONGS_EQUAL(1, read->parts);
  LONGS_EQUAL(7, read->number);
  LONGS_EQUAL(3, read->message_bytes);
  LONGS_EQUAL(0, read_datagram(whole(kChannel, ""))->data.size());
}

TEST(LcmDatagram, HoldsAPartOfAMessage) {
  const Bytes bytes = part({0, 0, 0, 9}, {0, 0, 0, 6}, 1, 2, "abc");
  const auto read = read_datagram(bytes);
  CHECK_TRUE(read.has_value());
  CHECK_TRUE(read->channel.empty());
  CHECK_TRUE(std::ranges::equal(read->data, bytes_of("abc")));
  LONGS_EQUAL(9, read->message_bytes);
  LONGS_EQUAL(6, read->at);
  LONGS_EQUAL(1, read->part);
  LONGS_EQUAL(2, read->parts);
}

TEST(LcmDatagram, IsNothingWithoutLcmsMarkOrAnEndOfItsChannel) {
  Bytes bytes = whole(kChannel, "arm");
  bytes[3] = '1';
  CHECK_FALSE(read_datagram(bytes).has_value());
  CHECK_FALSE(read_datagram(whole("", "arm")).has_value());
  CHECK_TRUE(read_datagram(whole(std::string(63, 'x'), "arm")).has_value());
  CHECK_FALSE(read_datagram(whole(std::string(64, 'x'), "arm")).has_value());
  Bytes endless = bytes_of("LC02");
  endless.resize(60'000, 'x');
  CHECK_FALSE(read_datagram(endless).has_value());
}

TEST(LcmDatagram, IsNothingIfItsPartLiesOutsideTheMessage) {
  CHECK_TRUE(read_datagram(part({0, 0, 0, 3}, {0, 0, 0, 0}, 1, 2, "abc")).has_value());
  CHECK_FALSE(read_datagram(part({0, 0, 0, 3}, {0, 0, 0, 1}, 1, 2, "abc")).has_value());
  CHECK_FALSE(read_datagram(part({0, 0, 0, 3}, {0xff, 0xff, 0xff, 0xfe}, 1, 2, "abc")).has_value());
  CHECK_FALSE(read_datagram(part({0, 0, 0, 3}, {0, 0, 0, 0}, 2, 2, "abc")).has_value());
  CHECK_FALSE(read_datagram(part({0, 0, 0, 3}, {0, 0, 0, 0}, 0, 0, "abc")).has_value());
}

TEST(LcmDatagram, MayBeCutAnywhere) {
  for (const Bytes& bytes :
       {whole(kChannel, ""), part({0, 0, 0, 9}, {0, 0, 0, 0}, 0, 2, std::string("a\0b", 3))}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const auto read = read_datagram(std::span(bytes).first(size));
      CHECK_TRUE(!read || read->parts == 2);
    }
  }
}
