// The audit finds what it is there to find.
#include "tests/campaigns/audit.hpp"

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "firmware/publisher/journal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::loss;
using strobe_msgs::event_t;

namespace {

constexpr std::int64_t kBoot = 7;

template <typename Content>
firmware::Message message(const std::string& kind, const Content& content) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(content.getEncodedSize()));
  content.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {firmware::Message::Kind::event, {}, "STROBE/bench/" + kind, bytes};
}

firmware::Message event(std::int64_t sequence, std::int8_t kind = event_t::FLASH, std::int32_t shot_id = 0,
                        const std::string& detail = "") {
  event_t content{};
  content.boot_id = kBoot;
  content.sequence = sequence;
  content.kind = kind;
  content.shot_id = shot_id;
  content.detail = detail;
  return message("EVENT", content);
}

firmware::Message shot(std::int32_t shot_id, std::int64_t first, std::int64_t last) {
  strobe_msgs::shot_t content{};
  content.boot_id = kBoot;
  content.shot_id = shot_id;
  content.first_sequence = first;
  content.last_sequence = last;
  return message("SHOT", content);
}

firmware::Message status(std::int64_t last_sequence) {
  strobe_msgs::status_t content{};
  content.boot_id = kBoot;
  content.last_sequence = last_sequence;
  return message("STATUS", content);
}

firmware::Message readout(std::int32_t shot_id, bool flagged) {
  strobe_msgs::readout_t content{};
  content.boot_id = kBoot;
  content.shot_id = shot_id;
  if (flagged) content.flags.emplace_back("events_missing");
  content.flag_count = static_cast<std::int32_t>(content.flags.size());
  return message("READOUT", content);
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
  Audit result() { return audit(folder.path(), folder.path()); }
};

TEST(Audit, IsContentWithAWholeSession) {
  journal({event(1), event(2, event_t::SHOT_STARTED, 1), event(3), shot(1, 2, 3)});
  host({event(3), event(1)});
  host({event(2, event_t::SHOT_STARTED, 1), shot(1, 2, 3), readout(1, false)});
  const Audit audit = result();
  LONGS_EQUAL(0, audit.violations.size());
  LONGS_EQUAL(3, audit.journalled);
  LONGS_EQUAL(1, audit.shots);
  LONGS_EQUAL(1, audit.readouts);
}

TEST(Audit, FindsEventsAndSummariesThatAreOnNoHost) {
  journal({event(1), event(2), shot(1, 1, 2)});
  host({event(1)});
  LONGS_EQUAL(1, result().missing);
  LONGS_EQUAL(1, result().shots_missing);
  LONGS_EQUAL(2, result().violations.size());
}

TEST(Audit, ExpectsOfTheNewestBootWhatItsLastHeardStatusTellsOf) {
  journal({event(1), event(2), event(3), shot(1, 1, 2), shot(2, 3, 3)});
  host({event(1), status(2)});
  LONGS_EQUAL(1, result().missing);
  LONGS_EQUAL(1, result().later);
  LONGS_EQUAL(1, result().shots_missing);
}

TEST(Audit, ExpectsEverythingOfAnEarlierBoot) {
  firmware::Message of_next_boot = event(1);
  of_next_boot.bytes[19] = 8;  // the boot's last byte
  journal({event(1), event(2)});
  journal({of_next_boot});
  host({event(1), status(1), of_next_boot});
  LONGS_EQUAL(1, result().missing);
}

TEST(Audit, FindsWhatDiffersFromTheJournalOrIsInNone) {
  journal({event(1)});
  host({event(1, event_t::GATE), event(2)});
  LONGS_EQUAL(2, result().violations.size());
}

TEST(Audit, FindsReadoutsGivenTwiceOrTooEarly) {
  journal({event(1), event(2), shot(1, 1, 2), shot(2, 1, 2)});
  host({event(1), shot(1, 1, 2), shot(2, 1, 2), readout(1, true), readout(2, false), event(2)});
  host({readout(1, true)});
  const Audit audit = result();
  LONGS_EQUAL(1, audit.twice);
  LONGS_EQUAL(1, audit.incomplete_unflagged);
  LONGS_EQUAL(2, audit.flagged);
}

TEST(Audit, WantsAShotWithoutAnEndToBeTold) {
  journal({event(1, event_t::SHOT_STARTED, 4)});
  host({event(1, event_t::SHOT_STARTED, 4)});
  LONGS_EQUAL(1, result().cut_off);
  LONGS_EQUAL(0, result().cut_off_reported);
  LONGS_EQUAL(1, result().violations.size());
  const auto reported = event(1, event_t::REPAIRED, 0,
                              "boot 0000000000000007: shot 4 has no end; what came after event 1 is lost");
  firmware::Message of_next_boot = reported;
  of_next_boot.bytes[19] = 8;  // the boot's last byte
  journal({of_next_boot});
  host({of_next_boot});
  LONGS_EQUAL(1, result().cut_off_reported);
  LONGS_EQUAL(0, result().violations.size());
}

TEST(Audit, FindsGapsAndTornEndsInAJournal) {
  journal({event(1), event(3)});
  host({event(1), event(3)});
  LONGS_EQUAL(1, result().violations.size());
}
