// Contact sets are user files: any bytes are either rows of finite numbers or an error of one line.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/contact/differentiation.hpp"
#include "common/contact/standard_error.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe::contact;
  const std::string_view text = text_of(data, size);
  const auto set = strobe::data::parse_contact_csv(text, "fuzz.csv");
  if (!set) return require_one_line(set.error().message, "fuzz.csv:"), 0;
  require(!set->rows.empty());
  for (const strobe::data::ContactRow& row : set->rows)
    require(std::isfinite(row.time_fraction) && std::isfinite(row.x_fraction) &&
            std::isfinite(row.y_fraction) && std::isfinite(row.rotation_fraction.value()));
  const ContactInputs inputs{15.62, -6.701, 0.865, 0.55, 5.1996e-3, 0.0629};
  if (const auto see = pulse_standard_errors(*set, inputs))
    require(std::isfinite(see->see_x_m) && see->n >= 2);
  const FractionFits fits = fit_fractions(*set);
  if (fits.x) require(std::isfinite(fits.x->coefficients[3]));
  return 0;
}
