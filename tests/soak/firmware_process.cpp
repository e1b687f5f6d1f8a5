#include "tests/soak/firmware_process.hpp"

#include <variant>

#include "firmware/publisher/journal_folder.hpp"

namespace strobe::soak {

namespace {

firmware::PublisherSettings publisher_settings(const FirmwareProcess::Settings& settings,
                                               const firmware::FolderFindings& found) {
  firmware::PublisherSettings result;
  result.boot_id = settings.boot_id;
  result.session = settings.session;
  result.real_time = true;
  result.wall_ns = settings.wall_ns;
  result.boot_time_ns = settings.boot_time_ns;
  result.say = settings.say;
  result.found = found;
  return result;
}

}  // namespace

FirmwareProcess::FirmwareProcess(const firmware::Rig& rig, const FirmwarePorts& ports,
                                 const Settings& settings, const firmware::FolderFindings& found,
                                 firmware::Journal journal)
    : boot_id_(settings.boot_id),
      queue_(rig, ports.publisher_wake),
      commands_(ports.loop_wake),
      journal_(std::move(journal)),
      bus_(ports.bus, settings.key, settings.boot_id),
      outputs_(rig, ports.loop_clock, ports.outputs),
      sequencer_(rig, {ports.loop_clock, outputs_, ports.edges, queue_, commands_}, found.last_shot_id),
      publisher_(rig, publisher_settings(settings, found), queue_, mailbox_, journal_, bus_,
                 ports.publisher_clock),
      rejections_(ports.publisher_clock, settings.say),
      receiver_(rig, settings.boot_id, settings.key, commands_, mailbox_, rejections_, settings.boot_time_ns,
                settings.draw_token) {}

Result<std::unique_ptr<FirmwareProcess>> FirmwareProcess::start(const firmware::Rig& rig,
                                                                const FirmwarePorts& ports,
                                                                const Settings& settings) {
  const firmware::FolderFindings found = firmware::repair_journals(settings.session);
  for (const std::string& line : found.repaired) settings.say(line);
  auto journal = firmware::Journal::create(settings.session, settings.boot_id);
  if (!journal) return tl::unexpected(journal.error());
  return std::unique_ptr<FirmwareProcess>(
      new FirmwareProcess(rig, ports, settings, found, std::move(*journal)));
}

int FirmwareProcess::drop_queue() {
  int events = 0;
  firmware::LoopQueue::Item item;
  while (queue_.pop(item)) events += std::holds_alternative<firmware::Event>(item) ? 1 : 0;
  return events;
}

}  // namespace strobe::soak
