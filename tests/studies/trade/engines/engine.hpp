// General engines that a user would otherwise take, on the bounce of a ball: how one is asked. Each is
// optional when the program is built. One thread's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::studies::trade {

/// A contact of Hunt and Crossley's law on the sphere:
/// f = stiffness·y^1.5·(1 + 1.5·dissipation·dy/dt), friction mu·f·min(1, slip/transition) at the level of the
/// surface, (R - y) beneath the centre.
struct HertzContact {
  double stiffness = 0.0;  ///< N/m^1.5
  double dissipation_spm = 0.0, transition_mps = 0.0;
};

/// What an engine is to simulate; no gravity, no offset, no tangential compliance.
struct EngineBounce {
  ball::Ball ball;
  impact::Motion touchdown;
  double e = 0.0, mu = 0.0, dwell_s = 0.0;
  HertzContact hertz{};  ///< with that e and dwell time, for engines of that law
};

/// The law of the contact, and with it what is exact.
enum class EngineLaw {
  rigid,   ///< e and mu: impact::rigid()
  spring,  ///< spring and dashpot that only push, Coulomb friction: impact::rigid() too, as friction follows
           ///< N
  hertz,   ///< Hunt and Crossley's, with friction that sets in over a transition velocity: integrated
};

/// A way to use an engine.
struct EngineSetting {
  std::string name;
  EngineLaw law = EngineLaw::rigid;
  std::string control = "step_s";  ///< what `values` are: step_s or accuracy
  std::vector<double> values;      ///< coarse to fine
  double transition_mps = 0.0;     ///< of a hertz law
};

struct EngineRun {
  bool left = false;  ///< the ball left the surface
  impact::Motion lift_off;
  double contact_us = 0.0;  ///< time taken from the step in which it touches to that in which it leaves
  double simulated_s = 0.0;
  int steps = 0;
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  virtual std::vector<EngineSetting> settings() const = 0;
  /// `phase` (0...1): how much of its first step the ball is away from the surface.
  virtual EngineRun bounce(const EngineSetting& setting, double value, const EngineBounce& bounce,
                           double phase) = 0;
};

/// Null: not installed.
std::unique_ptr<Engine> make_bullet();
std::unique_ptr<Engine> make_open_dynamics();
std::unique_ptr<Engine> make_simbody();

/// Decades and thirds of them from `coarse` down to `fine`.
std::vector<double> falling(double coarse, double fine);

/// The contact of that law with the bounce's e and dwell time.
HertzContact hertz_contact(const EngineBounce& bounce, double transition_mps);

/// Lift-off by that law, in long double with `steps` steps of Fehlberg 7(8).
impact::Motion hertz_lift_off(const EngineBounce& bounce, int steps);

}  // namespace strobe::studies::trade
