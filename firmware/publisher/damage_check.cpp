#include "firmware/publisher/damage_check.hpp"

#include "firmware/publisher/journal.hpp"

namespace strobe::firmware {

bool DamageCheck::step() {
  const wire::LogReader::Step step = log_.advance(record_);
  if (step == wire::LogReader::Step::record) {
    damaged_ += record_.offset - whole_end_;
    whole_end_ = log_.at();
  }
  return step != wire::LogReader::Step::end;
}

std::string DamageCheck::finding() const {
  if (damaged_ == 0) return "";
  return "boot " + boot_in_hex(boot_id_) + ": " + std::to_string(damaged_) +
         " bytes in the middle of its journal are damaged";
}

}  // namespace strobe::firmware
