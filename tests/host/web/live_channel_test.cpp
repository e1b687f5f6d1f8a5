#include "host/web/live_channel.hpp"

#include <poll.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/support/string_from.hpp"

using namespace strobe::web;
using namespace std::chrono_literals;
using Given = LiveChannel::Given;

namespace {

LiveMessage note(const std::string& text) { return LiveNotification{"", text}; }
std::string text_of(const LiveMessage& message) { return std::get<LiveNotification>(message).text; }

bool readable(int descriptor) {
  pollfd polled{descriptor, POLLIN, 0};
  return poll(&polled, 1, 0) == 1;
}

}  // namespace

TEST_GROUP(LiveChannel) {
  LiveChannel channel;
  std::deque<LiveMessage> messages;
};

TEST(LiveChannel, HandsMessagesOverInTheirOrder) {
  messages = {note("a"), note("b")};
  channel.put(messages);
  CHECK(messages.empty());
  messages = {note("c")};
  channel.put(messages);
  const auto taken = channel.take();
  LONGS_EQUAL(3, taken.messages.size());
  CHECK_EQUAL("a", text_of(taken.messages[0]));
  CHECK_EQUAL("c", text_of(taken.messages[2]));
  CHECK(!taken.ended);
}

TEST(LiveChannel, LeavesWhatDoesNotFitWithItsOwner) {
  for (std::size_t i = 0; i < LiveChannel::kMaxMessages + 5; ++i) messages.push_back(note(std::to_string(i)));
  channel.put(messages);
  LONGS_EQUAL(5, messages.size());
  CHECK_EQUAL(std::to_string(LiveChannel::kMaxMessages), text_of(messages.front()));
  LONGS_EQUAL(LiveChannel::kMaxMessages, channel.take().messages.size());
  channel.put(messages);
  CHECK(messages.empty());
}

TEST(LiveChannel, LosesNothingBetweenThreads) {
  constexpr int kCount = 20000;
  std::atomic<int> wrong{0};
  std::thread reader([this, &wrong] {
    for (int next = 0; next < kCount;) {
      for (const LiveMessage& message : channel.take().messages)
        if (text_of(message) != std::to_string(next++)) ++wrong;
    }
  });
  for (int i = 0; i < kCount; ++i) {
    messages.push_back(note(std::to_string(i)));
    channel.put(messages);
  }
  while (!messages.empty()) channel.put(messages);
  reader.join();
  LONGS_EQUAL(0, wrong);
}

TEST(LiveChannel, WakesTheHostWithWhatIsAskedOfIt) {
  CHECK(!readable(channel.descriptor()));
  CHECK(channel.take_commands().empty());
  CHECK(channel.command({LiveCommand::Kind::disarm, "127.0.0.1"}, 0ms) == Given::waits);
  CHECK(readable(channel.descriptor()));
  const auto commands = channel.take_commands();
  LONGS_EQUAL(1, commands.size());
  CHECK(commands[0].kind == LiveCommand::Kind::disarm);
  CHECK_EQUAL("127.0.0.1", commands[0].from);
  CHECK(!readable(channel.descriptor()));
  CHECK(channel.take_commands().empty());
}

TEST(LiveChannel, SaysThatACommandIsTakenOnceItIs) {
  std::atomic<int> taken{0};
  std::thread asker([this, &taken] {
    for (int i = 0; i < 2; ++i) taken += channel.command({}, 60s) == Given::taken ? 1 : 0;
  });
  for (int all = 0; all < 2;) {
    while (!readable(channel.descriptor())) std::this_thread::yield();
    LONGS_EQUAL(all, taken);  // not before
    all += static_cast<int>(channel.take_commands().size());
    while (taken < all) std::this_thread::yield();
  }
  asker.join();
  LONGS_EQUAL(2, taken);
}

TEST(LiveChannel, WaitsForALoopThatStandsStillOnceAndNotForEachCommand) {
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < LiveChannel::kMaxCommands; ++i)
    CHECK(channel.command({}, 300ms) == Given::waits);
  CHECK(std::chrono::steady_clock::now() - begun >= 300ms);
  CHECK(std::chrono::steady_clock::now() - begun < 16 * 300ms);
  CHECK(channel.command({}, 300ms) == Given::too_many);
  LONGS_EQUAL(LiveChannel::kMaxCommands, channel.take_commands().size());  // a late stop is one
  CHECK(channel.command({}, 0ms) == Given::waits);
}

TEST(LiveChannel, EndsForWhoWaitsForTheLoop) {
  std::thread asker([this] { CHECK(channel.command({}, 3600s) == Given::waits); });
  channel.end();
  asker.join();
}

TEST(LiveChannel, EndsForWhoWaits) {
  std::thread reader([this] { CHECK(channel.take().ended); });
  channel.end();
  reader.join();
}
