#include "host/digitize/pattern/dot_pattern.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common/data/csv.hpp"

namespace strobe::digitize {
namespace {

constexpr double kUnitWithin = 0.01;

Result<Eigen::Vector3d> direction_of(const std::vector<double>& numbers, std::string_view source, int line) {
  if (numbers.size() == 3) {
    const Eigen::Vector3d direction(numbers[0], numbers[1], numbers[2]);
    if (!(std::abs(direction.norm() - 1.0) <= kUnitWithin))
      return data::csv_error(
          source, line, "",
          fmt::format("a direction of length {:.4g} is none of length 1", direction.norm()));
    return Eigen::Vector3d(direction.normalized());
  }
  if (!(numbers[0] >= 0.0 && numbers[0] <= 180.0))
    return data::csv_error(source, line, "theta", "must be from 0 to 180 degrees");
  if (!(std::abs(numbers[1]) <= 360.0))
    return data::csv_error(source, line, "phi", "must be from -360 to 360 degrees");
  const double theta = numbers[0] * std::numbers::pi / 180.0, phi = numbers[1] * std::numbers::pi / 180.0;
  return Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
}

std::string_view trimmed(std::string_view text) {
  const auto from = text.find_first_not_of(" \t");
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t") - from + 1);
}

Result<std::vector<double>> numbers_of(const data::CsvRow& row, std::string_view source) {
  std::vector<double> numbers;
  for (const std::string& cell : row.cells) {
    const auto number = data::parse_number(trimmed(cell), source, row.line, "");
    if (!number) return tl::unexpected(number.error());
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

Result<DotPattern> parse_dot_pattern(std::string_view text, std::string_view source) {
  DotPattern pattern;
  std::size_t columns = 0;
  for (const data::CsvRow& row : data::csv_rows(text)) {
    if (row.cells.front().starts_with('#')) continue;
    if (columns == 0) columns = row.cells.size();
    if (row.cells.size() != columns || columns < 2 || columns > 3)
      return data::csv_error(source, row.line, "", "must be x,y,z or theta,phi, all rows alike");
    const auto numbers = numbers_of(row, source);
    if (!numbers) return tl::unexpected(numbers.error());
    const auto direction = direction_of(*numbers, source, row.line);
    if (!direction) return tl::unexpected(direction.error());
    for (const Eigen::Vector3d& other : pattern.dots) {
      if (direction->dot(other) > std::cos(kMinDotsApart_rad))
        return data::csv_error(source, row.line, "",
                               fmt::format("less than {:.2g} degrees from another dot",
                                           kMinDotsApart_rad * 180.0 / std::numbers::pi));
    }
    pattern.dots.push_back(*direction);
    if (pattern.dots.size() > kMaxPatternDots)
      return data::csv_error(source, row.line, "", fmt::format("more than {} dots", kMaxPatternDots));
  }
  if (pattern.dots.size() < kMinPatternDots)
    return fail(
        fmt::format("{}: {} dots; a pattern has {} or more", source, pattern.dots.size(), kMinPatternDots));
  return pattern;
}

}  // namespace strobe::digitize
