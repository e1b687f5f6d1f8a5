// Simbody: a sphere on a free joint over a half space, Hunt and Crossley's contact.
#include "tests/studies/trade/engines/engine.hpp"

#if STROBE_WITH_SIMBODY

#include <Simbody.h>

#include <chrono>
#include <cmath>

namespace strobe::studies::trade {

namespace {

constexpr const char* kMerson = "Runge-Kutta-Merson, transition .01 m/s";
constexpr const char* kMersonSoft = "Runge-Kutta-Merson, transition .1 m/s";
constexpr const char* kSemiExplicit = "semi-explicit Euler 2, transition .1 m/s";
constexpr const char* kBdf = "CPodes (BDF), transition .1 m/s";

/// The plane is this many times as stiff as the ball, so that the contact is at its level.
constexpr double kPlaneStiffer = 1e9;

class Simbody : public Engine {
 public:
  std::string name() const override { return "simbody"; }

  std::vector<EngineSetting> settings() const override {
    const std::vector<double> accuracies{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7};
    return {{kMerson, EngineLaw::hertz, "accuracy", accuracies, 0.01},
            {kMersonSoft, EngineLaw::hertz, "accuracy", accuracies, 0.1},
            {kSemiExplicit, EngineLaw::hertz, "accuracy", std::vector<double>{1e-1, 1e-2, 1e-3, 1e-4}, 0.1},
            {kBdf, EngineLaw::hertz, "accuracy", accuracies, 0.1}};
  }

  EngineRun bounce(const EngineSetting& setting, double accuracy, const EngineBounce& b,
                   double phase) override {
    using namespace SimTK;
    const HertzContact& law = b.hertz;
    MultibodySystem system;
    SimbodyMatterSubsystem matter(system);
    GeneralForceSubsystem forces(system);
    GeneralContactSubsystem contacts(system);
    const ContactSetIndex set = contacts.createContactSet();
    const double radius = b.ball.radius_m(), inertia = b.ball.inertia_kgm2();
    Body::Rigid body(MassProperties(b.ball.mass_kg, Vec3(0), Inertia(inertia)));
    MobilizedBody::Planar ball(matter.Ground(), body);
    // A half space is on the side of its +x.
    contacts.addBody(set, matter.Ground(), ContactGeometry::HalfSpace(),
                     Transform(Rotation(-0.5 * Pi, ZAxis), Vec3(0)));
    contacts.addBody(set, ball, ContactGeometry::Sphere(radius), Transform());
    HuntCrossleyForce force(forces, contacts, set);
    // Its force is 4/3·sqrt(R)·E·y^1.5.
    const double modulus = law.stiffness / (4.0 / 3.0 * std::sqrt(radius));
    force.setBodyParameters(ContactSurfaceIndex(0), modulus * kPlaneStiffer, 0, b.mu, b.mu, 0);
    force.setBodyParameters(ContactSurfaceIndex(1), modulus, law.dissipation_spm, b.mu, b.mu, 0);
    force.setTransitionVelocity(law.transition_mps);
    State state = system.realizeTopology();
    const double before_s = 1e-3 * b.dwell_s * phase;
    ball.setQ(state, Vec3(0, 0, radius - b.touchdown.vy_mps * before_s));
    ball.setU(state, Vec3(b.touchdown.omega_radps, b.touchdown.vx_mps, b.touchdown.vy_mps));

    const auto integrator = make_integrator(setting.name, system);
    integrator->setAccuracy(accuracy);
    integrator->initialize(state);
    EngineRun run;
    run.simulated_s = before_s + 1.02 * b.dwell_s;
    const auto begin = std::chrono::steady_clock::now();
    try {
      // Its first return is the start itself.
      while (integrator->getTime() < run.simulated_s) integrator->stepTo(run.simulated_s, run.simulated_s);
    } catch (const std::exception&) {
      return run;
    }
    run.contact_us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    run.steps = integrator->getNumStepsTaken();
    const State& end = integrator->getState();
    run.left = ball.getQ(end)[2] >= radius && ball.getU(end)[2] > 0;
    run.lift_off = {ball.getU(end)[1], ball.getU(end)[2], ball.getU(end)[0]};
    return run;
  }

 private:
  static std::unique_ptr<SimTK::Integrator> make_integrator(const std::string& name,
                                                            const SimTK::System& system) {
    using namespace SimTK;
    if (name == kSemiExplicit) return std::make_unique<SemiExplicitEuler2Integrator>(system);
    if (name == kBdf) return std::make_unique<CPodesIntegrator>(system, CPodes::BDF);
    return std::make_unique<RungeKuttaMersonIntegrator>(system);
  }
};

}  // namespace

std::unique_ptr<Engine> make_simbody() { return std::make_unique<Simbody>(); }

}  // namespace strobe::studies::trade

#else

namespace strobe::studies::trade {

std::unique_ptr<Engine> make_simbody() { return nullptr; }

}  // namespace strobe::studies::trade

#endif
