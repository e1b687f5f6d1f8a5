#include "firmware/linux/system_files.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace strobe::firmware {

std::optional<std::string> SystemFiles::read(const std::string& path) const {
  std::ifstream file(root_ / path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  std::string all = text.str();
  all.erase(all.find_last_not_of(" \t\r\n") + 1);
  return all;
}

bool SystemFiles::write(const std::string& path, const std::string& text) const {
  std::ofstream file(root_ / path);
  return file && (file << text << std::flush);
}

std::vector<std::string> SystemFiles::list(const std::string& path) const {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator at(root_ / path, error), end; !error && at != end;
       at.increment(error))
    names.push_back(at->path().filename());
  const auto key = [](const std::string& name) {
    return std::pair(std::strtol(name.c_str(), nullptr, 10), name);
  };
  std::sort(names.begin(), names.end(),
            [&](const std::string& a, const std::string& b) { return key(a) < key(b); });
  return names;
}

bool SystemFiles::is_folder(const std::string& path) const {
  std::error_code error;
  return std::filesystem::is_directory(root_ / path, error);
}

std::optional<std::string> SystemFiles::resolved(const std::string& path) const {
  std::error_code error;
  const auto root = std::filesystem::canonical(root_, error);
  if (error) return std::nullopt;
  const auto found = std::filesystem::canonical(root_ / path, error);
  if (error) return std::nullopt;
  const std::string relative = found.lexically_relative(root).string();
  if (relative.starts_with("..")) return std::nullopt;
  return relative;
}

bool SystemFiles::owner_may_write(const std::string& path) const {
  std::error_code error;
  const auto status = std::filesystem::status(root_ / path, error);
  return !error &&
         (status.permissions() & std::filesystem::perms::owner_write) != std::filesystem::perms::none;
}

std::set<int> parse_cpu_list(const std::string& list) {
  constexpr int kMaxCpus = 8192;
  std::set<int> cpus;
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0;
    int last = 0;
    const int read = std::sscanf(part.c_str(), "%d-%d", &first, &last);
    if (read < 1 || first < 0) continue;
    if (read == 1) last = first;
    for (int cpu = first; cpu <= std::min(last, kMaxCpus); ++cpu) cpus.insert(cpu);
  }
  return cpus;
}

std::set<int> parse_cpu_mask(const std::string& mask) {
  constexpr int kBitsOfDigit = 4;
  std::set<int> cpus;
  int first = 0;
  for (auto at = mask.rbegin(); at != mask.rend(); ++at) {
    if (*at == ',') continue;
    const std::size_t digit = std::string("0123456789abcdef").find(*at);
    if (digit == std::string::npos) return {};
    for (int bit = 0; bit < kBitsOfDigit; ++bit)
      if ((digit >> bit & 1) != 0) cpus.insert(first + bit);
    first += kBitsOfDigit;
  }
  return cpus;
}

std::string format_cpu_mask(const std::set<int>& cpus) {
  constexpr int kBitsOfGroup = 32;
  const int groups = cpus.empty() ? 1 : *cpus.rbegin() / kBitsOfGroup + 1;
  std::string mask;
  for (int group = groups - 1; group >= 0; --group) {
    std::uint32_t bits = 0;
    for (const int cpu : cpus)
      if (cpu / kBitsOfGroup == group) bits |= std::uint32_t{1} << (cpu % kBitsOfGroup);
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), mask.empty() ? "%x" : ",%08x", bits);
    mask += text.data();
  }
  return mask;
}

std::string format_cpu_list(const std::set<int>& cpus) {
  std::string list;
  for (auto at = cpus.begin(); at != cpus.end();) {
    const int first = *at;
    int last = first;
    while (++at != cpus.end() && *at == last + 1) ++last;
    if (!list.empty()) list.append(",");
    list.append(std::to_string(first));
    if (last > first) list.append("-").append(std::to_string(last));
  }
  return list;
}

std::set<int> allowed_cpus(int cpu, const SystemFiles& files) {
  if (cpu >= 0) return {cpu};
  return parse_cpu_list(files.read("sys/devices/system/cpu/online").value_or("0"));
}

}  // namespace strobe::firmware
