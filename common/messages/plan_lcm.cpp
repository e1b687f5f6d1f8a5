#include "common/messages/plan_lcm.hpp"

namespace strobe::messages {

using strobe_msgs::plan_t;

static_assert(static_cast<int>(Lamps::both) == strobe_msgs::coded_flash_t::BOTH_LAMPS);
static_assert(static_cast<int>(Train::free) == plan_t::TRAIN_FREE);
static_assert(static_cast<int>(Train::gated) == plan_t::TRAIN_GATED);

plan_t plan_to_lcm(const ShotPlan& plan) {
  plan_t message{};
  message.train = static_cast<std::int8_t>(plan.train);
  message.period_ns = plan.period.count();
  message.flash_count = plan.flash_count;
  message.shutter_open_ns = plan.exposure.count();
  message.gate_delay_ns = plan.gate_delay.count();
  message.impact_at_ns = plan.impact_at.count();
  message.dry = plan.dry;
  for (const CodedFlash& flash : plan.code) {
    message.code.emplace_back();
    message.code.back().offset_ns = flash.offset.count();
    message.code.back().lamps = static_cast<std::int8_t>(flash.lamps);
  }
  message.code_count = static_cast<std::int32_t>(message.code.size());
  return message;
}

ShotPlan plan_from_lcm(const plan_t& message) {
  ShotPlan plan;
  plan.train = static_cast<Train>(message.train);
  plan.period = nanoseconds(message.period_ns);
  plan.flash_count = message.flash_count;
  plan.exposure = nanoseconds(message.shutter_open_ns);
  plan.gate_delay = nanoseconds(message.gate_delay_ns);
  plan.impact_at = nanoseconds(message.impact_at_ns);
  plan.dry = message.dry != 0;
  for (const auto& flash : message.code) {
    if (plan.code.size() == kMaxCodedFlashes) break;
    plan.code.push_back({nanoseconds(flash.offset_ns), static_cast<Lamps>(flash.lamps)});
  }
  return plan;
}

}  // namespace strobe::messages
