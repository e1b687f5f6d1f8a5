// Plans come from people: any bytes are either a plan within its limits that can be written and read again,
// or an error of one line that names the file.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/config/plan_file.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::host;
  const std::string_view text = text_of(data, size);
  const auto plan = read_plan(text, "fuzz.toml", {});
  if (!plan) return require_one_line(plan.error().message, "fuzz.toml"), 0;
  const strobe::ShotPlan& even = plan->even;
  require(even.period >= strobe::microseconds{100} && even.period <= even.exposure);
  require((even.train == strobe::Train::gated) == (even.flash_count >= 1));
  require(plan->coded() == !plan->shot().code.empty());
  const auto again = read_plan(plan_to_toml(*plan), "again.toml", {});
  require(again.has_value() && *again == *plan);
  return 0;
}
