// ODE, the Open Dynamics Engine (double precision): a sphere over a plane.
#include "tests/studies/trade/engines/engine.hpp"

#if STROBE_WITH_ODE

#include <ode/ode.h>

#include <chrono>

namespace strobe::studies::trade {

namespace {

constexpr const char* kShipped = "bounce, as shipped";
constexpr const char* kFreeOfCorrection = "bounce, no correction nor softness";
constexpr const char* kQuick = "bounce, the same, quick step";
constexpr const char* kSpring = "spring by erp and cfm";
constexpr const char* kSpringQuick = "spring by erp and cfm, quick step";

/// The library is set up once.
struct Library {
  Library() { dInitODE2(0); }
  ~Library() { dCloseODE(); }
};

class OpenDynamics : public Engine {
 public:
  std::string name() const override { return "ode_engine"; }

  std::vector<EngineSetting> settings() const override {
    const auto steps = falling(1e-2, 1e-6);
    const auto fine = falling(1e-3, 1e-6);
    return {{.name = kShipped, .law = EngineLaw::rigid, .values = steps},
            {.name = kFreeOfCorrection, .law = EngineLaw::rigid, .values = steps},
            {.name = kQuick, .law = EngineLaw::rigid, .values = steps},
            {.name = kSpring, .law = EngineLaw::spring, .values = fine},
            {.name = kSpringQuick, .law = EngineLaw::spring, .values = fine}};
  }

  EngineRun bounce(const EngineSetting& setting, double step_s, const EngineBounce& b,
                   double phase) override {
    const double radius = b.ball.radius_m();
    const dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, 0);
    if (setting.name != kShipped) dWorldSetCFM(world, 0);
    if (setting.law == EngineLaw::rigid && setting.name != kShipped)
      dWorldSetContactMaxCorrectingVel(world, 0);
    const dBodyID ball = dBodyCreate(world);
    dMass mass;
    const double inertia = b.ball.inertia_kgm2();
    dMassSetParameters(&mass, b.ball.mass_kg, 0, 0, 0, inertia, inertia, inertia, 0, 0, 0);
    dBodySetMass(ball, &mass);
    dBodySetGyroscopicMode(ball, 0);
    dBodySetFiniteRotationMode(ball, 0);
    dBodySetAutoDisableFlag(ball, 0);
    dBodySetPosition(ball, 0, radius - b.touchdown.vy_mps * step_s * phase, 0);
    dBodySetLinearVel(ball, b.touchdown.vx_mps, b.touchdown.vy_mps, 0);
    dBodySetAngularVel(ball, 0, 0, b.touchdown.omega_radps);
    const dGeomID sphere = dCreateSphere(nullptr, radius);
    dGeomSetBody(sphere, ball);
    const dGeomID plane = dCreatePlane(nullptr, 0, 1, 0, 0);
    const dJointGroupID joints = dJointGroupCreate(0);
    const dContact contact = contact_of(setting, step_s, b);
    const bool quick = setting.name == kQuick || setting.name == kSpringQuick;

    EngineRun run;
    const int most = static_cast<int>(10.0 * b.dwell_s / step_s) + 20;
    const auto begin = std::chrono::steady_clock::now();
    while (!run.left && run.steps < most) {
      dContact touching = contact;
      if (dCollide(sphere, plane, 1, &touching.geom, sizeof(dContact)) > 0)
        dJointAttach(dJointCreateContact(world, joints, &touching), ball, nullptr);
      if (quick)
        dWorldQuickStep(world, step_s);
      else
        dWorldStep(world, step_s);
      dJointGroupEmpty(joints);
      ++run.steps;
      run.left = dBodyGetLinearVel(ball)[1] > 0 && dBodyGetPosition(ball)[1] >= radius;
    }
    run.contact_us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    run.simulated_s = run.steps * step_s;
    run.lift_off = {dBodyGetLinearVel(ball)[0], dBodyGetLinearVel(ball)[1], dBodyGetAngularVel(ball)[2]};
    dJointGroupDestroy(joints);
    dGeomDestroy(sphere);
    dGeomDestroy(plane);
    dWorldDestroy(world);
    return run;
  }

 private:
  static dContact contact_of(const EngineSetting& setting, double step_s, const EngineBounce& b) {
    dContact contact{};
    // Friction along x, its limit from the normal force itself.
    contact.surface.mode = dContactApprox1 | dContactFDir1;
    contact.surface.mu = b.mu;
    contact.fdir1[0] = 1;
    if (setting.law == EngineLaw::rigid) {
      contact.surface.mode |= dContactBounce;
      contact.surface.bounce = b.e;
      contact.surface.bounce_vel = 0;
    } else {
      // The manual's own translation of a spring and a damper (section 3.8.2).
      const auto spring = impact::normal_spring(b.ball.mass_kg, b.e, b.dwell_s);
      const double k = step_s * spring->stiffness_npm;
      contact.surface.mode |= dContactSoftERP | dContactSoftCFM;
      contact.surface.soft_erp = k / (k + spring->damping_nspm);
      contact.surface.soft_cfm = 1.0 / (k + spring->damping_nspm);
    }
    return contact;
  }

  Library library_;
};

}  // namespace

std::unique_ptr<Engine> make_open_dynamics() { return std::make_unique<OpenDynamics>(); }

}  // namespace strobe::studies::trade

#else

namespace strobe::studies::trade {

std::unique_ptr<Engine> make_open_dynamics() { return nullptr; }

}  // namespace strobe::studies::trade

#endif
