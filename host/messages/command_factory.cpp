#include "host/messages/command_factory.hpp"

#include "common/authentication/seal.hpp"
#include "common/messages/danger.hpp"
#include "common/messages/plan_lcm.hpp"
#include "common/messages/record.hpp"

namespace strobe::host {

using strobe_msgs::command_t;

command_t CommandFactory::make(std::int64_t boot_id, std::int8_t kind) {
  command_t command{};
  command.schema_version = command_t::SCHEMA_VERSION;
  command.host_id = host_id_;
  command.command_id = next_id_++;
  command.boot_id = boot_id;
  command.kind = kind;
  return command;
}

/// With who asks, for a person.
command_t CommandFactory::named(command_t command) const {
  if (host_name_.empty()) return command;
  command.notes = messages::notes_from_record({{std::string(messages::kHostNameNote), host_name_}});
  command.note_count = static_cast<std::int32_t>(command.notes.size());
  return command;
}

command_t CommandFactory::arm(std::int64_t boot_id) { return named(make(boot_id, command_t::ARM)); }
command_t CommandFactory::disarm(std::int64_t boot_id) { return named(make(boot_id, command_t::DISARM)); }
command_t CommandFactory::reset(std::int64_t boot_id) { return named(make(boot_id, command_t::RESET)); }
command_t CommandFactory::clear(std::int64_t boot_id) { return make(boot_id, command_t::CLEAR); }

command_t CommandFactory::fire(std::int64_t boot_id, std::int64_t arm_token, const ShotPlan& plan,
                               const reduction::Record& notes) {
  command_t command = make(boot_id, command_t::FIRE);
  command.arm_token = arm_token;
  command.plan = messages::plan_to_lcm(plan);
  command.notes = messages::notes_from_record(notes);
  command.note_count = static_cast<std::int32_t>(command.notes.size());
  return command;
}

command_t CommandFactory::resend(std::int64_t boot_id, const EventRange& range) {
  command_t command = make(boot_id, command_t::RESEND);
  command.resend_boot_id = range.boot_id;
  command.resend_first = range.sequences.first;
  command.resend_last = range.sequences.last;
  return command;
}

Result<std::vector<std::uint8_t>> CommandSealer::seal(const command_t& command) const {
  std::vector<std::uint8_t> body(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(body.data(), 0, static_cast<int>(body.size()));
  return authentication::seal(key_, rig_, body);
}

}  // namespace strobe::host
