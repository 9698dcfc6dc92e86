// Bullet's soft bodies in single precision, as Debian builds them: the position-based solver of btSoftRigidDynamicsWorld, and
// the explicit and implicit mass-spring force of btDeformableMultiBodyDynamicsWorld. The world has no other bodies.
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <map>
#include <memory>

#include "peers/peer.hpp"

namespace dvdx::bench {
namespace {

btScalar scalar(double value) { return static_cast<btScalar>(value); }

// The objects that every Bullet world needs.
struct Surroundings {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

std::unique_ptr<btSoftBody> body_of(const Cloth& cloth, btSoftBodyWorldInfo& info) {
  const std::size_t n = cloth.nodes();
  const std::vector<double>& x = cloth.start.x;
  std::vector<btVector3> points;
  std::vector<btScalar> masses;
  for (std::size_t i = 0; i < n; ++i) {
    points.emplace_back(scalar(x[i]), scalar(x[n + i]), scalar(x[2 * n + i]));
    masses.push_back(cloth.inverse_mass[i] > 0 ? scalar(cloth.node_mass()) : 0);
  }
  auto body = std::make_unique<btSoftBody>(&info, static_cast<int>(n), points.data(), masses.data());
  body->setActivationState(DISABLE_DEACTIVATION);
  body->m_cfg.collisions = 0;
  return body;
}

void set_world(btSoftBodyWorldInfo& info, Surroundings& surroundings) {
  info.m_dispatcher = &surroundings.dispatcher;
  info.m_broadphase = &surroundings.broadphase;
  info.m_gravity = {0, scalar(-gravity), 0};
  info.air_density = 0;
}

Motion motion_of(const btSoftBody& body) {
  Motion motion;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < body.m_nodes.size(); ++i) motion.x.push_back(static_cast<double>(body.m_nodes[i].m_x[axis]));
    for (int i = 0; i < body.m_nodes.size(); ++i) motion.v.push_back(static_cast<double>(body.m_nodes[i].m_v[axis]));
  }
  return motion;
}

template <class World>
double time_steps(World& world, int substeps, double seconds) {
  return time_once([&] {
    for (std::size_t i = 0; i < steps_of(seconds, substeps); ++i) world.stepSimulation(scalar(frame_time / substeps), 0);
  });
}

// All iterations of a sub-step together remove the share of a spring's error that XPBD with the compliance 1/stiffness removes.
// Bullet itself sets a share for each iteration, which makes its cloth's stiffness depend on the step.
void link_by_share(btSoftBody& body, const Cloth& cloth, int substeps, int iterations) {
  const double h = frame_time / substeps;
  std::map<double, btSoftBody::Material*> materials;  // by the sum of the inverse masses
  for (const Edge& edge : cloth.edges) {
    const double w = cloth.inverse_mass[edge.a] + cloth.inverse_mass[edge.b];
    btSoftBody::Material*& material = materials[w];
    if (material == nullptr) {
      const double share = w > 0 ? w / (w + 1 / (cloth.stiffness * h * h)) : 1;
      material = body.appendMaterial();
      material->m_kLST = scalar(1 - std::pow(1 - share, 1.0 / iterations));
    }
    body.appendLink(static_cast<int>(edge.a), static_cast<int>(edge.b), material);
  }
}

tl::expected<Outcome, std::string> run_position_based(const Cloth& cloth, int substeps, int iterations, double seconds) {
  Surroundings surroundings;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&surroundings.dispatcher, &surroundings.broadphase, &solver, &surroundings.configuration);
  set_world(world.getWorldInfo(), surroundings);
  const auto body = body_of(cloth, world.getWorldInfo());
  link_by_share(*body, cloth, substeps, iterations);
  body->m_cfg.piterations = iterations;
  world.addSoftBody(body.get());
  const double taken = time_steps(world, substeps, seconds);
  Outcome outcome{motion_of(*body), taken};
  world.removeSoftBody(body.get());
  return outcome;
}

tl::expected<Outcome, std::string> run_deformable(const Cloth& cloth, int substeps, bool is_implicit, double seconds) {
  Surroundings surroundings;
  btDeformableBodySolver bodies;
  btDeformableMultiBodyConstraintSolver solver;
  solver.setDeformableSolver(&bodies);
  btDeformableMultiBodyDynamicsWorld world(&surroundings.dispatcher, &surroundings.broadphase, &solver,
                                           &surroundings.configuration, &bodies);
  set_world(world.getWorldInfo(), surroundings);
  world.setImplicit(is_implicit);
  world.setUseProjection(true);  // without projection the implicit solver does not move a cloth with fixed nodes
  const auto body = body_of(cloth, world.getWorldInfo());
  for (const Edge& edge : cloth.edges) body->appendLink(static_cast<int>(edge.a), static_cast<int>(edge.b));
  body->m_sleepingThreshold = 0;
  body->setDampingCoefficient(0);
  btDeformableMassSpringForce springs(scalar(cloth.stiffness), 0);
  btDeformableGravityForce weight({0, scalar(-gravity), 0});
  world.addSoftBody(body.get());
  world.addForce(body.get(), &springs);
  world.addForce(body.get(), &weight);
  const double taken = time_steps(world, substeps, seconds);
  Outcome outcome{motion_of(*body), taken};
  world.removeSoftBody(body.get());
  return outcome;
}

Peer position_based(const std::string& name, int iterations) {
  return {name + "position based, " + std::to_string(iterations) + (iterations == 1 ? " iteration" : " iterations") + ", f32",
          "sub-steps", any_ladder, [iterations](const Cloth& cloth, int substeps, double seconds) {
            return run_position_based(cloth, substeps, iterations, seconds);
          }};
}

// Backward Euler is stable at the whole frame.
std::vector<int> implicit_ladder(const Cloth& cloth) {
  std::vector<int> ladder = any_ladder(cloth);
  ladder.insert(ladder.begin(), {1, 2});
  return ladder;
}

}  // namespace

Peers bullet_peers() {
  const std::string name =
      "Bullet " + std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100) + " ";
  return {position_based(name, 1),
          position_based(name, 4),
          {name + "mass-spring, explicit, f32", "sub-steps", leapfrog_ladder,
           [](const Cloth& cloth, int substeps, double seconds) { return run_deformable(cloth, substeps, false, seconds); }},
          {name + "mass-spring, implicit, f32", "sub-steps", implicit_ladder,
           [](const Cloth& cloth, int substeps, double seconds) { return run_deformable(cloth, substeps, true, seconds); }}};
}

}  // namespace dvdx::bench
