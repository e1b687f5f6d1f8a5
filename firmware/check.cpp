#include "firmware/check.hpp"

#include <unistd.h>

#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "firmware/linux/gpio_lines.hpp"
#include "firmware/linux/guardian.hpp"
#include "firmware/linux/real_time.hpp"

namespace strobe::firmware {

namespace {

class Report {
 public:
  explicit Report(bool json) : json_(json) {}
  void item(const std::string& name, const std::string& fault, bool tolerated = false) {
    if (!fault.empty() && !tolerated) ++faults_;
    if (json_) {
      const nlohmann::json object{
          {"item", name}, {"ok", fault.empty()}, {"tolerated", tolerated && !fault.empty()}, {"what", fault}};
      std::printf("%s\n", object.dump().c_str());
    } else {
      std::printf("%-16s %s%s\n", name.c_str(),
                  fault.empty() ? "ok"
                  : tolerated   ? "tolerated: "
                                : "",
                  fault.c_str());
    }
  }
  int faults() const { return faults_; }

 private:
  bool json_;
  int faults_ = 0;
};

std::string session_fault(const std::filesystem::path& session) {
  if (session.empty()) return "no --session given: where is the journal to go?";
  std::error_code error;
  std::filesystem::path existing = std::filesystem::absolute(session);
  while (!std::filesystem::exists(existing, error) && existing.has_relative_path())
    existing = existing.parent_path();
  if (!std::filesystem::is_directory(existing, error)) return existing.string() + " is not a folder";
  if (access(existing.c_str(), W_OK | X_OK) != 0)
    return existing.string() + " cannot be written by this user";
  const auto space = std::filesystem::space(existing, error);
  constexpr std::uintmax_t kLeast = std::uintmax_t{100} << 20;  // some 500 shots
  if (!error && space.available < kLeast) {
    return existing.string() + " has only " + std::to_string(space.available >> 20) + " MiB left";
  }
  return "";
}

}  // namespace

int check_rig(const Rig& rig, const Options& options) {
  Report report(options.json);
  report.item("rig file", "");
  for (const LineReport& line : inspect_lines(rig)) report.item(line.key, line.fault);
  std::string rights;
  for (const std::string& fault : try_real_time(rig.real_time))
    rights += (rights.empty() ? "" : "; ") + fault;
  report.item("real time", rights, options.allow_no_rt);
  report.item("latency", LatencyRequest().fault(), true);
  report.item("session", session_fault(options.session));
  lcm::LCM lcm(options.lcm_url);
  report.item(
      "lcm",
      lcm.good() ? "" : options.lcm_url + ": is there a multicast route? (ip route add 224.0.0.0/4 dev lo)");
  return report.faults() == 0 ? kExitDone : kExitFailed;
}

}  // namespace strobe::firmware
