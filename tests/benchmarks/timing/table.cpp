#include "tests/benchmarks/timing/table.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace strobe::benchmarks::timing {

std::string ratios(const Percentiles& of, const Percentiles& to) {
  const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%.2g %.2g %.2g %.2g", ratio(of.p50_us, to.p50_us),
                ratio(of.p99_us, to.p99_us), ratio(of.p999_us, to.p999_us), ratio(of.max_us, to.max_us));
  return text.data();
}

void print_rows(const std::vector<Row>& rows, bool json, const std::string& ratio_to) {
  if (!json)
    std::printf("%-7s %-26s %-9s %7s %9s %9s %9s %10s %7s  %s\n", "load", "lateness [us] of", "freezes", "n",
                "p50", "p99", "p99.9", "max", "core %", ratio_to.c_str());
  for (const Row& row : rows) {
    const Percentiles& p = row.lateness;
    if (json) {
      nlohmann::json object{{"load", row.load},     {"what", row.what},   {"freezes", row.freezes},
                            {"n", p.count},         {"p50_us", p.p50_us}, {"p99_us", p.p99_us},
                            {"p999_us", p.p999_us}, {"max_us", p.max_us}};
      if (row.cpu_percent >= 0.0) object["core_percent"] = row.cpu_percent;
      std::printf("%s\n", object.dump().c_str());
      continue;
    }
    std::array<char, 16> core{};
    if (row.cpu_percent >= 0.0) std::snprintf(core.data(), core.size(), "%.1f", row.cpu_percent);
    std::printf("%-7s %-26s %-9s %7zu %9.2f %9.2f %9.2f %10.2f %7s  %s\n", row.load.c_str(), row.what.c_str(),
                row.freezes.c_str(), p.count, p.p50_us, p.p99_us, p.p999_us, p.max_us, core.data(),
                row.ratio.c_str());
  }
  std::fflush(stdout);
}

void write_csv(const std::string& path, const std::vector<Row>& rows) {
  std::ofstream file(path);
  file << "load,what,freezes,n,p50_us,p99_us,p999_us,max_us,core_percent\n";
  for (const Row& row : rows) {
    const Percentiles& p = row.lateness;
    file << row.load << ',' << row.what << ',' << row.freezes << ',' << p.count << ',' << p.p50_us << ','
         << p.p99_us << ',' << p.p999_us << ',' << p.max_us << ',';
    if (row.cpu_percent >= 0.0) file << row.cpu_percent;
    file << '\n';
  }
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace strobe::benchmarks::timing
