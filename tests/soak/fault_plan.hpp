// What goes wrong in the virtual lab, as probabilities. Plain values; parsing allocates; thread-safe.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "sim/scene/faults.hpp"
#include "tests/soak/random.hpp"

namespace strobe::soak {

/// What strikes the processes and the people, beside the bench's own faults (sim/scene/faults.hpp).
enum class Hazard {
  key_off,         ///< the key is turned off, and on again up to 2 s later
  estop,           ///< the e-stop is pressed, and released up to 2 s later
  firmware_kill,   ///< the daemon dies; its guardian takes the outputs, then it is started again
  firmware_stop,   ///< it is asked to end, and started again
  firmware_hang,   ///< its loop stands still until the guardian kills it
  loop_freeze,     ///< the whole machine stands still for 10 to 170 ms
  loop_delay,      ///< the loop is not run for 20 us to 5 ms
  host_kill,       ///< the host dies and is started again, as another host, in the same session folder
  wall_step,       ///< the wall clock is set, by up to a day
  disk_full,       ///< the journal's disk is full for up to 2 s
  command_replay,  ///< a command of earlier on comes again
};
inline constexpr std::array<std::string_view, 11> kHazardNames{
    "key_off",    "estop",     "firmware_kill", "firmware_stop", "firmware_hang", "loop_freeze",
    "loop_delay", "host_kill", "wall_step",     "disk_full",     "command_replay"};
inline constexpr std::size_t kHazardCount = kHazardNames.size();
constexpr std::string_view name(Hazard hazard) { return kHazardNames[static_cast<std::size_t>(hazard)]; }

struct FaultPlan {
  std::string name = "none";
  std::array<double, sim::kFaultNames.size()> bench{};  ///< of each kind of sim::FaultKind, per exposure
  std::array<double, kHazardCount> hazard{};            ///< per second of virtual time
  double packet_loss = 0.0;                             ///< per packet and receiver
  double packet_duplication = 0.0;
  double packet_reordering = 0.0;

  double& operator[](sim::FaultKind kind) { return bench[static_cast<std::size_t>(kind)]; }
  double operator[](Hazard which) const { return hazard[static_cast<std::size_t>(which)]; }
  double& operator[](Hazard which) { return hazard[static_cast<std::size_t>(which)]; }
};

FaultPlan no_faults();
/// What a well-kept bench sees on a bad day: a few per cent of the shots are struck.
FaultPlan mild_faults();
/// Every other shot is struck by something, often by several things; one packet in ten is lost.
FaultPlan wild_faults();

/// A file with keys of the names above at its top level: the kinds of sim/scene/faults.hpp, of Hazard, and
/// packet_loss, packet_duplication, packet_reordering; 0 to 1, 0 where absent. Error: "FILE:LINE: key: what".
Result<FaultPlan> read_fault_plan(std::string_view text, const std::string& file_name);

/// "none", "mild", "wild", or a file's name.
Result<FaultPlan> find_fault_plan(const std::string& word);

/// The bench's faults of exposures 1 ... shots.
std::vector<sim::Fault> draw_bench_faults(const FaultPlan& plan, int shots, Random& random);

}  // namespace strobe::soak
