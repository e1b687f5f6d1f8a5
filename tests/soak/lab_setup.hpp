// Set-up of one run: scene and shot plan, drawn from a seed. Pure; thread-safe.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/config/plan_file.hpp"
#include "sim/scene/faults.hpp"
#include "sim/scene/scene.hpp"
#include "tests/soak/bus.hpp"

namespace strobe::soak {

enum class PlanKind {
  shipped,   ///< the shipped rig file's: 167 flashes in 0.5 s
  brief,     ///< free trains of 70 to 110 ms around the impact
  gated,     ///< bursts after the light gate
  coded,     ///< as brief, at unequal intervals, some flashes left out, some of one lamp
  mixed,     ///< one run in ten as shipped, one in ten gated, the others brief
  extremes,  ///< mixed, of balls that are slowest, fastest, grazing, steep, most spun, or hardly seen
};

struct LabSetup {
  sim::Scene scene;
  host::PlanFile plan;
  reduction::Record notes;
};

LabSetup draw_lab_setup(PlanKind kind, const host::PlanFile& shipped, Random& random);

/// "shipped", "brief", "gated", "coded", "mixed", "extremes".
Result<PlanKind> find_plan_kind(std::string_view word);

// Faults in the virtual lab, as probabilities. Plain values; parsing allocates; thread-safe.

/// Faults of processes, disk, clock and operator, beside those of the rig (sim/scene/faults.hpp).
enum class Hazard {
  key_off,           ///< the key is turned off, and on again up to 2 s later
  estop,             ///< the e-stop is pressed, and released up to 2 s later
  firmware_kill,     ///< the daemon dies; its guardian takes the outputs, then it is started again
  firmware_stop,     ///< the daemon is asked to end, and started again
  firmware_hang,     ///< the loop stops until the guardian kills the daemon
  loop_freeze,       ///< the whole machine stops for 10 to 170 ms
  loop_delay,        ///< the loop is not run for 20 us to 5 ms
  host_kill,         ///< the host dies; another host is started in the same session folder
  wall_step,         ///< the wall clock is set, by up to a day
  disk_full,         ///< the journal's disk is full for up to 2 s
  command_replay,    ///< an earlier command is sent again
  ctrl_c,            ///< the operator ends the series: the shot under way first, if one is
  stop_at_once,      ///< the operator asks twice, to stop at once
  page_disarm,        ///< a page of another host, which only watches, disarms
  other_series,      ///< another host fires a series of its own
  firmware_suspend,  ///< the firmware's machine sleeps for up to 20 s, and the bench stands still with it
  host_suspend,      ///< the host's machine sleeps for up to 20 s
  network_outage,    ///< nothing comes through for up to 5 s
};
inline constexpr std::array<std::string_view, 18> kHazardNames{
    "key_off",      "estop",       "firmware_kill", "firmware_stop",    "firmware_hang",  "loop_freeze",
    "loop_delay",   "host_kill",   "wall_step",     "disk_full",        "command_replay", "ctrl_c",
    "stop_at_once", "page_disarm", "other_series",  "firmware_suspend", "host_suspend",   "network_outage"};
inline constexpr std::size_t kHazardCount = kHazardNames.size();
constexpr std::string_view name(Hazard hazard) { return kHazardNames[static_cast<std::size_t>(hazard)]; }

/// Those of a camera that is a device of its own come after them: this lab has none.
inline constexpr std::size_t kRigFaultCount = static_cast<std::size_t>(sim::FaultKind::frame_dropped);

struct FaultPlan {
  std::string name = "none";
  std::array<double, kRigFaultCount> rig{};   ///< of each kind of sim::FaultKind, per exposure
  std::array<double, kHazardCount> hazard{};          ///< per second of virtual time
  double packet_loss = 0.0;                           ///< per packet and receiver
  double packet_duplication = 0.0, packet_reordering = 0.0;
  double strangers = 0.0;    ///< per packet to the host: one that is forged, altered or late comes, too
  double played_back = 0.0;  ///< likewise: one of yesterday's, sealed with the lab's key

  double& operator[](sim::FaultKind kind) { return rig[static_cast<std::size_t>(kind)]; }
  double operator[](Hazard which) const { return hazard[static_cast<std::size_t>(which)]; }
  double& operator[](Hazard which) { return hazard[static_cast<std::size_t>(which)]; }
};

FaultPlan no_faults();
/// A well-kept lab on a bad day: faults in a few per cent of the shots.
FaultPlan mild_faults();
/// Faults in every other shot, often several; one packet in ten is lost.
FaultPlan wild_faults();

/// Stops of every kind, one every other second or so, among other hosts and on a bad network.
FaultPlan stop_faults();

/// A file with keys of the names above at its top level: the kinds of sim/scene/faults.hpp, of Hazard, and
/// packet_loss, packet_duplication, packet_reordering, strangers, played_back; 0 to 1, 0 where absent. Error: "FILE:LINE: key: what".
Result<FaultPlan> read_fault_plan(std::string_view text, const std::string& file_name);

/// "none", "mild", "wild", "stops", or a file's name.
Result<FaultPlan> find_fault_plan(const std::string& word);

/// The rig's faults of exposures 1 to `shots`.
std::vector<sim::Fault> draw_rig_faults(const FaultPlan& plan, int shots, Random& random);

}  // namespace strobe::soak
