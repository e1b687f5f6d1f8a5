// /dev/pio0 as the driver sees it. Numbers and bytes of its requests are written down from its header, include/uapi/misc/
// rp1_pio_if.h of raspberrypi/linux: 0x40000000 for _IOW or 0xc0000000 for _IOWR, the size of the arguments in the bits
// from 16 on, 'f' (102), the number; fields in their order, as a 64-bit little-endian machine lays them out.
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include "firmware/rp1_pio/dev_pio.hpp"

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using firmware::DevPio;

namespace {

constexpr unsigned long kConfigXfer = 0x40086600, kXferData = 0x40106601, kAddProgram = 0x4044660b, kIsClaimed = 0x40026616,
                        kInit = 0x4014661e, kExec = 0x40066620, kSetEnabled = 0x40046625, kEnableSync = 0x40026628,
                        kGet = 0xc008662a, kFifoState = 0x4008662c, kSetFunction = 0x40046633;

using Bytes = std::vector<unsigned>;
struct Call {
  unsigned long request;
  Bytes bytes;
};

/// The driver, as far as it is asked.
struct Driver {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Call> calls;
  int error = 0;        ///< of every request
  unsigned claimed = 0;
  std::vector<std::uint32_t> words;  ///< from a machine
  unsigned level = 0;   ///< of the queue to a machine
  unsigned fills_by = 8;
  int transfers = 0;    ///< that have begun
  int expected = 0;     ///< transfers, for which who asks for the queue's level is made to wait
  bool transfers_end = false;

  void end_transfers() {
    const std::lock_guard lock(mutex);
    transfers_end = true;
    changed.notify_all();
  }
  void set_level(unsigned words_queued) {
    const std::lock_guard lock(mutex);
    level = words_queued;
  }
  const Call& last() const { return calls.back(); }
};
Driver* driver = nullptr;

int fake_ioctl(int fd, unsigned long request, void* argument) {
  std::unique_lock lock(driver->mutex);
  if (fd != 1000) return errno = EBADF, -1;
  const std::size_t size = request >> 16 & 0x3fff;
  auto* const bytes = static_cast<unsigned char*>(argument);
  driver->calls.push_back({request, Bytes(bytes, bytes + size)});
  if (driver->error != 0) return errno = driver->error, -1;
  if (request == kIsClaimed) return (driver->claimed & bytes[0]) != 0 ? 1 : 0;
  if (request == kFifoState) {
    const bool to_machine = bytes[2] != 0;
    if (to_machine) driver->changed.wait_for(lock, std::chrono::seconds(60), [] { return driver->transfers >= driver->expected; });
    bytes[4] = static_cast<unsigned char>(to_machine ? driver->level : driver->words.size());
    bytes[6] = bytes[4] == 0 ? 1 : 0;
    return 8;
  }
  if (request == kGet) {
    const std::uint32_t word = driver->words.empty() ? 0xdead'beef : driver->words.front();
    if (!driver->words.empty()) driver->words.erase(driver->words.begin());
    std::memcpy(bytes + 4, &word, sizeof word);
    return 8;
  }
  if (request != kXferData) return 0;
  driver->level = driver->fills_by;
  ++driver->transfers;
  driver->changed.notify_all();
  driver->changed.wait(lock, [] { return driver->transfers_end; });
  return errno = ETIMEDOUT, -1;  // a long train, which goes on
}

}  // namespace

TEST_GROUP(DevPio) {
  Driver fake;
  std::unique_ptr<DevPio> block;

  void setup() override {
    driver = &fake;
    block = std::make_unique<DevPio>(1000, fake_ioctl);
  }
  void teardown() override {
    fake.end_transfers();
    block.reset();
  }
  void check_last(unsigned long request, const Bytes& bytes) {
    UNSIGNED_LONGS_EQUAL(request, fake.last().request);
    CHECK_TRUE(bytes == fake.last().bytes);
  }
  bool transfer(unsigned machine, const std::vector<std::uint32_t>& words) {
    ++fake.expected;
    return block->transfer(machine, words);
  }
  int count_of(unsigned long request) {
    const std::lock_guard lock(fake.mutex);
    int count = 0;
    for (const Call& call : fake.calls) count += call.request == request ? 1 : 0;
    return count;
  }
  static std::string why_not(const std::string& device) {
    firmware::Rig rig;
    rig.file_name = "rig.toml";
    rig.pio = {device, 7};
    const auto opened = DevPio::open(rig);
    CHECK_FALSE(opened.has_value());
    return opened ? "" : opened.error().message;
  }
};

TEST(DevPio, EachRequestIsAsTheDriversHeaderHasIt) {
  const std::vector<std::uint16_t> program{0x0102, 0xa003};
  CHECK_TRUE(block->load(program));
  Bytes add{2, 0, 0, 0, 0x02, 0x01, 0x03, 0xa0};
  add.resize(68);
  check_last(kAddProgram, add);

  CHECK_TRUE(block->set_up(2, {0x10000, 0x11223344, 0x55667788, 0x99aabbcc}, 9));
  check_last(kInit, {2, 0, 9, 0, 0, 0, 1, 0, 0x44, 0x33, 0x22, 0x11, 0x88, 0x77, 0x66, 0x55, 0xcc, 0xbb, 0xaa, 0x99});
  UNSIGNED_LONGS_EQUAL(kSetEnabled, fake.calls.at(1).request);  // it is stopped first
  CHECK_TRUE((fake.calls.at(1).bytes == Bytes{4, 0, 0, 0}));

  CHECK_TRUE(block->execute(3, 0xa0c3));
  check_last(kExec, {3, 0, 0xc3, 0xa0, 0, 0});
  CHECK_TRUE(block->enable(3));
  check_last(kEnableSync, {3, 0});
  CHECK_TRUE(block->disable(12));
  check_last(kSetEnabled, {12, 0, 0, 0});
  CHECK_TRUE(block->drive(22));
  check_last(kSetFunction, {22, 0, 7, 0});

  fake.words = {0x01020304};
  CHECK_EQUAL(0x01020304U, block->get(1).value_or(0));
  UNSIGNED_LONGS_EQUAL(kFifoState, fake.calls.at(fake.calls.size() - 2).request);
  CHECK_TRUE((fake.calls.at(fake.calls.size() - 2).bytes == Bytes{1, 0, 0, 0, 0, 0, 0, 0}));
  check_last(kGet, {1, 0, 0, 0, 0, 0, 0, 0});
}

TEST(DevPio, AnEmptyQueueHasNoWord) {
  CHECK_FALSE(block->get(0).has_value());
  LONGS_EQUAL(0, count_of(kGet));
}

TEST(DevPio, ARequestThatFailsIsTold) {
  fake.error = EIO;
  CHECK_FALSE(block->load(std::vector<std::uint16_t>(3)));
  CHECK_FALSE(block->load(std::vector<std::uint16_t>(33)));
  CHECK_FALSE(block->set_up(0, {}, 0));
  CHECK_FALSE(block->execute(0, 0));
  CHECK_FALSE(block->enable(1));
  CHECK_FALSE(block->disable(1));
  CHECK_FALSE(block->drive(1));
  CHECK_FALSE(block->get(1).has_value());
  block->start(1);
  CHECK_FALSE(block->transfer(1, std::vector<std::uint32_t>(3)));
}

TEST(DevPio, ATransferDoesNotWaitForItsEnd) {
  block->start(1);
  const std::vector<std::uint32_t> words(4095);
  CHECK_TRUE(transfer(1, words));  // while its request sleeps
  LONGS_EQUAL(1, count_of(kConfigXfer));
  Bytes sent{1, 0, 0, 0, 0xfc, 0x3f, 0, 0};
  for (unsigned byte = 0; byte < 8; ++byte)
    sent.push_back(static_cast<unsigned>(reinterpret_cast<std::uintptr_t>(words.data()) >> (8 * byte) & 0xff));
  for (const Call& call : fake.calls) {
    if (call.request == kConfigXfer) CHECK_TRUE((call.bytes == Bytes{1, 0, 0, 0, 0, 0x40, 1, 0}));
    if (call.request == kXferData) CHECK_TRUE(call.bytes == sent);
  }
  CHECK_TRUE(block->transferring(1));
  CHECK_FALSE(block->transfer(1, words));  // one at a time
  CHECK_TRUE(transfer(0, words));
  CHECK_FALSE(block->transfer(2, words));
}

TEST(DevPio, ATransferIsOverWhenItsRequestAndItsQueueSaySo) {
  block->start(1);
  const std::vector<std::uint32_t> words(9);
  CHECK_TRUE(transfer(1, words));
  fake.end_transfers();  // the request fails: it was given up while the words still went
  CHECK_TRUE(block->transferring(1));
  CHECK_EQUAL(8U, block->queued(1).value_or(0));
  fake.set_level(0);
  while (block->transferring(1)) continue;
  CHECK_FALSE(block->transferring(0));
  CHECK_TRUE(transfer(1, words));
  LONGS_EQUAL(1, count_of(kConfigXfer));
}

TEST(DevPio, ATransferWhoseWordsDoNotComeIsTold) {
  block->start(1);
  fake.fills_by = 3;
  CHECK_FALSE(transfer(1, std::vector<std::uint32_t>(9)));
  CHECK_TRUE(transfer(0, std::vector<std::uint32_t>(3)));
  CHECK_FALSE(block->transfer(0, std::vector<std::uint32_t>(DevPio::kMaxWords + 1)));
}

TEST(DevPio, WhatCannotBeOpenedSaysWhatToDo) {
  STRCMP_CONTAINS("rig.toml:7: chip.pio: \"/dev/pio-of-none\" is not there: this takes a Raspberry Pi 5", why_not("/dev/pio-of-none").c_str());
  STRCMP_CONTAINS("\"/dev/null\" is no PIO block", why_not("/dev/null").c_str());
}

TEST(DevPio, MachinesOfAnotherProgramAreNotTaken) {
  STRCMP_EQUAL("", block->in_use().c_str());
  CHECK_TRUE((fake.calls.front().bytes == Bytes{1, 0}));
  CHECK_TRUE((fake.calls.back().bytes == Bytes{8, 0}));
  fake.claimed = 4;
  STRCMP_CONTAINS("another program uses", block->in_use().c_str());
  fake.error = ETIMEDOUT;
  STRCMP_CONTAINS("does not answer: ", block->in_use().c_str());
}
