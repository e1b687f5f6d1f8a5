// The audit finds what it is there to find.
#include "tests/campaigns/audit.hpp"

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/messages/well_formed.hpp"
#include "firmware/publisher/journal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::loss;
using strobe_msgs::event_t;

namespace {

constexpr std::int64_t kBoot = 7;

/// With what `fill` puts into it.
template <typename Content, typename Fill>
firmware::Message message(const std::string& kind, const Fill& fill) {
  Content content{};
  content.boot_id = kBoot;
  fill(content);
  return {firmware::Message::Kind::event, {}, "STROBE/bench/" + kind, messages::encode(content)};
}

firmware::Message event(std::int64_t sequence, std::int8_t kind = event_t::FLASH, std::int32_t shot_id = 0,
                        const std::string& detail = "") {
  return message<event_t>("EVENT", [&](event_t& event) {
    event.sequence = sequence;
    event.kind = kind;
    event.shot_id = shot_id;
    event.detail = detail;
  });
}

firmware::Message shot(std::int32_t shot_id, std::int64_t first, std::int64_t last) {
  return message<strobe_msgs::shot_t>("SHOT", [&](auto& shot) {
    shot.shot_id = shot_id;
    shot.first_sequence = first;
    shot.last_sequence = last;
  });
}

firmware::Message status(std::int64_t last_sequence) {
  return message<strobe_msgs::status_t>("STATUS",
                                        [&](auto& status) { status.last_sequence = last_sequence; });
}

firmware::Message readout(std::int32_t shot_id, bool flagged) {
  return message<strobe_msgs::readout_t>("READOUT", [&](auto& readout) {
    readout.shot_id = shot_id;
    if (flagged) readout.flags.emplace_back("events_missing");
    readout.flag_count = flagged ? 1 : 0;
  });
}

/// The same message by another boot.
firmware::Message of_next_boot(firmware::Message message) {
  message.bytes[19] = kBoot + 1;  // the boot's last byte
  return message;
}

}  // namespace

TEST_GROUP(Audit) {
  strobe::testing::TemporaryFolder folder;
  int logs = 0;

  void write(const std::string& name, const std::vector<firmware::Message>& messages) {
    auto journal = firmware::Journal::create(folder / "made", ++logs);
    CHECK(journal->append(messages, 0).has_value());
    std::filesystem::rename(journal->path(), folder / name);
  }
  void journal(const std::vector<firmware::Message>& messages) {
    write("journal-" + std::to_string(logs) + ".lcmlog", messages);
  }
  void host(const std::vector<firmware::Message>& messages) {
    write("host-" + std::to_string(logs) + ".lcmlog", messages);
  }
  void check(std::map<std::string, int> expected, std::size_t violations) {
    const auto found = audit(folder.path(), folder.path());
    LONGS_EQUAL(violations, found.violations.size());
    for (const auto& [what, count] : expected) LONGS_EQUAL_TEXT(count, found.counts.at(what), what.c_str());
  }
};

TEST(Audit, IsContentWithAWholeSession) {
  journal({event(1), event(2, event_t::SHOT_STARTED, 1), event(3), shot(1, 2, 3)});
  host({event(3), event(1)});
  host({event(2, event_t::SHOT_STARTED, 1), shot(1, 2, 3), readout(1, false)});
  check({{"events journalled", 3}, {"summaries", 1}, {"readouts", 1}}, 0);
}

TEST(Audit, FindsEventsAndSummariesThatAreOnNoHost) {
  journal({event(1), event(2), shot(1, 1, 2)});
  host({event(1)});
  check({{"missing events", 1}, {"missing summaries", 1}}, 2);
}

TEST(Audit, ExpectsOfTheNewestBootWhatItsLastHeardStatusTellsOf) {
  journal({event(1), event(2), event(3), shot(1, 1, 2), shot(2, 3, 3)});
  host({event(1), status(2)});
  check({{"missing events", 1}, {"events later", 1}, {"missing summaries", 1}}, 2);
}

TEST(Audit, ExpectsEverythingOfAnEarlierBoot) {
  journal({event(1), event(2)});
  journal({of_next_boot(event(1))});
  host({event(1), status(1), of_next_boot(event(1))});
  check({{"missing events", 1}}, 1);
}

TEST(Audit, FindsWhatDiffersFromTheJournalOrIsInNone) {
  journal({event(1)});
  host({event(1, event_t::GATE), event(2)});
  check({}, 2);
}

TEST(Audit, FindsReadoutsGivenTwiceOrTooEarly) {
  journal({event(1), event(2), shot(1, 1, 2), shot(2, 1, 2)});
  host({event(1), shot(1, 1, 2), shot(2, 1, 2), readout(1, true), readout(2, false), event(2)});
  host({readout(1, true)});
  check({{"readouts twice", 1}, {"readouts incomplete, unflagged", 1}, {"readouts flagged", 2}}, 2);
}

TEST(Audit, WantsAShotWithoutAnEndToBeTold) {
  journal({event(1, event_t::SHOT_STARTED, 4)});
  host({event(1, event_t::SHOT_STARTED, 4)});
  check({{"cut off", 1}, {"cut off, reported", 0}}, 1);
  const auto reported = of_next_boot(event(
      1, event_t::REPAIRED, 0, "boot 0000000000000007: shot 4 has no end; what came after event 1 is lost"));
  journal({reported});
  host({reported});
  check({{"cut off, reported", 1}}, 0);
}

TEST(Audit, FindsGapsAndTornEndsInAJournal) {
  journal({event(1), event(3)});
  host({event(1), event(3)});
  check({}, 1);
}
