#include "firmware/linux/smi_counter.hpp"

#include <cstdint>
#include <cstdlib>
#include <string>

namespace strobe::firmware {

SmiCounter::SmiCounter(const std::set<int>& cpus, const SystemFiles& files) {
  const std::string folder = "sys/bus/event_source/devices/msr/";
  const auto type = files.read(folder + "type");
  const auto event = files.read(folder + "events/smi");
  const std::string key = "event=";
  if (!type || !event || !event->starts_with(key)) return;
  perf_event_attr attributes{};
  attributes.size = sizeof attributes;
  attributes.type = static_cast<std::uint32_t>(std::strtoul(type->c_str(), nullptr, 10));
  attributes.config = std::strtoul(event->c_str() + key.size(), nullptr, 0);
  for (const int cpu : cpus) events_.emplace_back(attributes, -1, cpu);
}

long SmiCounter::count() const {
  long sum = 0;
  for (const PerfEvent& event : events_) {
    std::int64_t counted = 0;
    if (read(event.get(), &counted, sizeof counted) != sizeof counted) return -1;
    sum += counted;
  }
  return events_.empty() ? -1 : sum;
}

}  // namespace strobe::firmware
