// Plans come from people: any bytes are either a plan within its limits that can be written and read again,
// or an error of one line that names the file.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/config/plan_file.hpp"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::host;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto plan = read_plan(text, "fuzz.toml", {});
  if (!plan) {
    require(plan.error().message.starts_with("fuzz.toml"));
    require(plan.error().message.find('\n') == std::string::npos);
    return 0;
  }
  const strobe::ShotPlan& even = plan->even;
  require(even.period >= strobe::microseconds{100} && even.period <= even.exposure);
  require((even.train == strobe::Train::gated) == (even.flash_count >= 1));
  require(plan->coded() == !plan->shot().code.empty());
  const auto again = read_plan(plan_to_toml(*plan), "again.toml", {});
  require(again.has_value() && *again == *plan);
  return 0;
}
