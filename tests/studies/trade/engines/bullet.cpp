// Bullet (double precision): a sphere over a static plane.
#include "tests/studies/trade/engines/engine.hpp"

#if STROBE_WITH_BULLET

#include <btBulletDynamicsCommon.h>

#include <chrono>

namespace strobe::studies::trade {

namespace {

constexpr const char* kShipped = "as shipped";
constexpr const char* kTouching = "touching points only";
constexpr const char* kSplit = "touching points, split impulse";
constexpr const char* kSpring = "contact stiffness and damping";

class Bullet : public Engine {
 public:
  std::string name() const override { return "bullet"; }

  std::vector<EngineSetting> settings() const override {
    const auto steps = falling(1e-2, 1e-6);
    return {{.name = kShipped, .law = EngineLaw::rigid, .values = steps},
            {.name = kTouching, .law = EngineLaw::rigid, .values = steps},
            {.name = kSplit, .law = EngineLaw::rigid, .values = steps},
            {.name = kSpring, .law = EngineLaw::spring, .values = falling(1e-3, 1e-6)}};
  }

  EngineRun bounce(const EngineSetting& setting, double step_s, const EngineBounce& b,
                   double phase) override {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, 0});

    btStaticPlaneShape plane({0, 1, 0}, 0);
    btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, &plane));
    ground.setRestitution(1.0);
    ground.setFriction(1.0);
    world.addRigidBody(&ground);

    const double radius = b.ball.radius_m();
    btSphereShape sphere(radius);
    const double inertia = b.ball.inertia_kgm2();
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(b.ball.mass_kg, nullptr, &sphere,
                                                              {inertia, inertia, inertia}));
    ball.setRestitution(b.e);
    ball.setFriction(b.mu);
    ball.setDamping(0, 0);
    ball.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&ball);
    world.getSolverInfo().m_restitutionVelocityThreshold = 0;
    if (setting.name == kTouching || setting.name == kSplit) {
      ball.setContactProcessingThreshold(0);
      ground.setContactProcessingThreshold(0);
    }
    if (setting.name == kSplit) world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    if (setting.law == EngineLaw::spring) use_spring(ball, ground, b);

    btTransform start;
    start.setIdentity();
    start.setOrigin({0, radius - b.touchdown.vy_mps * step_s * phase, 0});
    ball.setWorldTransform(start);
    ball.setInterpolationWorldTransform(start);
    ball.setLinearVelocity({b.touchdown.vx_mps, b.touchdown.vy_mps, 0});
    ball.setAngularVelocity({0, 0, b.touchdown.omega_radps});

    EngineRun run;
    const int most = static_cast<int>(10.0 * b.dwell_s / step_s) + 20;
    const auto begin = std::chrono::steady_clock::now();
    while (!run.left && run.steps < most) {
      world.stepSimulation(step_s, 0);
      ++run.steps;
      run.left = ball.getLinearVelocity().y() > 0 && ball.getWorldTransform().getOrigin().y() >= radius;
    }
    run.contact_us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    run.simulated_s = run.steps * step_s;
    run.lift_off = {ball.getLinearVelocity().x(), ball.getLinearVelocity().y(),
                    ball.getAngularVelocity().z()};
    world.removeRigidBody(&ball);
    world.removeRigidBody(&ground);
    return run;
  }

 private:
  static void use_spring(btRigidBody& ball, btRigidBody& ground, const EngineBounce& b) {
    const auto spring = impact::normal_spring(b.ball.mass_kg, b.e, b.dwell_s);
    ball.setRestitution(0);
    ground.setRestitution(0);
    ball.setContactStiffnessAndDamping(spring->stiffness_npm, spring->damping_nspm);
    ground.setContactStiffnessAndDamping(BT_LARGE_FLOAT, 0);
    ball.setContactProcessingThreshold(0);
    ground.setContactProcessingThreshold(0);
  }
};

}  // namespace

std::unique_ptr<Engine> make_bullet() { return std::make_unique<Bullet>(); }

}  // namespace strobe::studies::trade

#else

namespace strobe::studies::trade {

std::unique_ptr<Engine> make_bullet() { return nullptr; }

}  // namespace strobe::studies::trade

#endif
