#include "host/commands/frontier/choice_json.hpp"

namespace strobe::host {

nlohmann::ordered_json row_json(const frontier::Row& row) {
  return {{"method", row.method},
          {"parameter", row.parameter},
          {"expected_error", row.error},
          {"expected_cost_us", row.cost_us}};
}

}  // namespace strobe::host
