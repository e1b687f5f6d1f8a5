#include "tests/benchmarks/timing/figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/figures/svg.hpp"
#include <string_view>


namespace strobe::benchmarks::timing {
namespace {

/// Told apart by the colour-blind too (Okabe and Ito).
constexpr std::array<const char*, 8> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                              "#E69F00", "#56B4E9", "#7A5C00", "#555555"};
constexpr double kMinUs = 1e-3;

}  // namespace

Sample sample_of(MonoTime due, MonoTime done, int cpu) {
  return {due, done, static_cast<double>((done - due).count()) * 1e-3, cpu};
}

Percentiles percentiles(std::vector<double> lateness_us) {
  if (lateness_us.empty()) return {};
  std::sort(lateness_us.begin(), lateness_us.end());
  const auto rank = [&](double p) {
    const double position = std::ceil(p * static_cast<double>(lateness_us.size()));
    return lateness_us[static_cast<std::size_t>(std::max(1.0, position)) - 1];
  };
  return {lateness_us.size(), rank(0.5), rank(0.99), rank(0.999), lateness_us.back()};
}

std::vector<double> latenesses(const std::vector<Sample>& samples) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(sample.lateness_us);
  return values;
}

std::vector<double> outside(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes) {
  std::vector<double> values;
  for (const Sample& sample : samples)
    if (!within_freeze(freezes, sample.from, sample.to, sample.cpu)) values.push_back(sample.lateness_us);
  return values;
}

void append(std::vector<Sample>& to, const std::vector<Sample>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

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

Curve exceedance(const std::string& title, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  Curve curve{title, {}, {}};
  // Points at equal steps of the share's logarithm: the tail has as many as the bulk.
  for (double share = 1.0; share >= 1.0 / std::max(1.0, n); share *= 0.93) {
    const auto rank = static_cast<std::size_t>(std::max(0.0, std::ceil((1.0 - share) * n) - 1.0));
    if (rank >= values.size()) break;
    curve.x.push_back(std::max(values[rank], kMinUs));
    curve.y.push_back(share);
  }
  return curve;
}

void draw(const std::string& svg, const std::vector<Panel>& panels) {
  figures::Figure figure{.title = "Shares of values above", .columns = static_cast<int>(panels.size())};
  for (const Panel& panel : panels) {
    figures::Panel& out = figure.panels.emplace_back();
    out.title = panel.title;
    out.x_label = panel.x_label;
    out.y_label = panel.y_label;
    out.log_x = panel.log_x;
    out.log_y = panel.log_y;
    for (std::size_t i = 0; i < panel.curves.size(); ++i) {
      const Curve& curve = panel.curves[i];
      figures::Series series{.name = panel.title + " " + curve.title,
                             .legend = &panel == &panels.front() ? curve.title : "",
                             .colour = kColours[i % kColours.size()]};
      for (std::size_t k = 0; k < curve.x.size(); ++k) series.points.push_back({curve.x[k], curve.y[k]});
      out.series.push_back(std::move(series));
    }
  }
  const std::filesystem::path file(svg);
  const auto drawn =
      figures::write_figure(figure, file.has_parent_path() ? file.parent_path() : ".", file.stem());
  if (!drawn) throw std::runtime_error(drawn.error().message);
}

std::optional<Sample> flash_of(const strobe_msgs::event_t& event, int cpu) {
  using strobe_msgs::event_t;
  if (event.kind == event_t::FLASH)
    return sample_of(from_ns(event.commanded_ns), from_ns(event.issue_start_ns), cpu);
  if (event.kind != event_t::SHOT_ABORTED || !event.detail.starts_with("flash ")) return std::nullopt;
  constexpr std::string_view kWords = " would have been ";
  const std::size_t at = event.detail.find(kWords);
  long late_us = 0;
  if (at == event.detail.npos ||
      std::sscanf(event.detail.c_str() + at + kWords.size(), "%ld us late", &late_us) != 1)
    return std::nullopt;
  const MonoTime then = from_ns(event.device_time_ns);
  return sample_of(then - microseconds(late_us), then, cpu);
}

KernelActivity kernel_activity(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes,
                               const std::vector<std::vector<CoreInterrupt>>& interrupts, Duration limit) {
  KernelActivity held;
  for (const Sample& sample : samples) {
    if (sample.cpu < 0 || sample.to - sample.from <= limit) continue;
    if (static_cast<std::size_t>(sample.cpu) >= interrupts.size()) continue;
    if (within_freeze(freezes, sample.from, sample.to, sample.cpu)) continue;
    ++held.late;
    const auto& of_core = interrupts[static_cast<std::size_t>(sample.cpu)];
    const auto before = [](const CoreInterrupt& interrupt, MonoTime t) { return interrupt.at < t; };
    auto each = std::lower_bound(of_core.begin(), of_core.end(), sample.from, before);
    for (; each != of_core.end() && each->at < sample.to; ++each) {
      ++held.interrupts;
      if (each->in_kernel) ++held.in_kernel;
    }
  }
  return held;
}

std::string in_words(const KernelActivity& held, Duration limit) {
  return std::to_string(held.late) + " later than " + std::to_string(limit / microseconds(1)) +
         " us outside freezes, meanwhile their core was in the kernel at " + std::to_string(held.in_kernel) +
         " of " + std::to_string(held.interrupts) + " looks";
}

std::vector<Sample> wake_ups_of(const std::vector<Duration>& lateness, MonoTime first_heard, Duration period,
                                int cpu) {
  if (lateness.empty()) return {};
  const MonoTime latest_begin = first_heard - lateness.front() - period - kAfterSecond;
  MonoTime due = std::chrono::floor<std::chrono::seconds>(latest_begin) + kAfterSecond + period;
  std::vector<Sample> samples;
  for (const Duration late : lateness) {
    const MonoTime woken = due + late;
    samples.push_back(sample_of(due, woken, cpu));
    due = due + period;
    while (woken > due) due = due + period;
  }
  return samples;
}

}  // namespace strobe::benchmarks::timing
