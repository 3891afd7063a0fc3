// Pinocchio's articulated-body algorithm behind plain C functions (see system.h for the arrays).
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>

#include <array>
#include <memory>
#include <vector>

#include "system.h"

namespace pin = pinocchio;
using Vector3 = Eigen::Vector3d;
using View = Eigen::Ref<const Eigen::VectorXd>; // what the wheel's library is instantiated for

namespace {

struct End {
    pin::JointIndex joint; // 0: the ground
    Vector3 at;            // in the frame of the joint
};

struct Spring {
    std::array<End, 2> ends;
    double stiffness, length, damping;
};

struct Torsion {
    int link;
    double stiffness, angle, damping;
};

struct Peer {
    pin::Model model;
    std::unique_ptr<pin::Data> data;
    pin::Convention convention;
    std::vector<int> turning; // per link: the link it turns against, -1 the ground, -2 slides
    std::vector<Spring> springs;
    std::vector<Torsion> torsions;
    Eigen::VectorXd q, v, tau;
    std::vector<double> acceleration; // absolute
    std::vector<pin::Force> external;
};

Peer *selected = nullptr;

Vector3 plane(double x, double z) { return {x, 0.0, z}; }

int angle_index(const double *links, int link) {
    while (link >= 0 && links[link * LINK_SIZE + REVOLUTE] == 0.0)
        link = static_cast<int>(links[link * LINK_SIZE + PARENT]);
    return link;
}

Vector3 to_centre(const double *links, int link) {
    return link < 0 ? Vector3(0, 0, 0)
                    : plane(links[link * LINK_SIZE + CHILD_X], links[link * LINK_SIZE + CHILD_Z]);
}

void add_link(Peer &peer, const double *links, int k) {
    const double *link = links + k * LINK_SIZE;
    const int parent = static_cast<int>(link[PARENT]);
    const bool revolute = link[REVOLUTE] != 0.0;
    const Vector3 at = to_centre(links, parent) + plane(link[PARENT_X], link[PARENT_Z]);
    const pin::SE3 placement(Eigen::Matrix3d::Identity(), at);
    const auto joint =
        revolute ? pin::JointModel(pin::JointModelRY())
                 : pin::JointModel(pin::JointModelPrismaticUnaligned(
                       plane(link[DIRECTION_X], link[DIRECTION_Z])));
    const auto id = peer.model.addJoint(static_cast<pin::JointIndex>(parent + 1), joint, placement,
                                        "joint" + std::to_string(k));
    const pin::Inertia inertia(link[MASS], to_centre(links, k),
                               link[INERTIA] * Eigen::Matrix3d::Identity());
    peer.model.appendBodyToJoint(id, inertia, pin::SE3::Identity());
    peer.turning.push_back(revolute ? angle_index(links, parent) : -2);
}

void pull(Peer &peer, const Spring &spring) {
    std::array<Vector3, 2> point, velocity;
    for (int k = 0; k < 2; k++) {
        const End &end = spring.ends[k];
        const pin::SE3 &frame = peer.data->oMi[end.joint];
        point[k] = frame.act(end.at);
        const pin::Motion &motion = peer.data->v[end.joint];
        velocity[k] = frame.rotation() * (motion.linear() + motion.angular().cross(end.at));
    }
    const Vector3 apart = point[1] - point[0];
    const double distance = apart.norm();
    const Vector3 along = apart / distance;
    const double size = spring.stiffness * (distance - spring.length) +
                        spring.damping * along.dot(velocity[1] - velocity[0]);
    for (int k = 0; k < 2; k++) {
        const End &end = spring.ends[k];
        const Vector3 force =
            peer.data->oMi[end.joint].rotation().transpose() * ((k ? -size : size) * along);
        peer.external[end.joint].linear() += force;
        peer.external[end.joint].angular() += end.at.cross(force);
    }
}

void forces(Peer &peer) {
    pin::forwardKinematics(peer.model, *peer.data, peer.q, peer.v);
    for (auto &force : peer.external) force.setZero();
    for (const Spring &spring : peer.springs) pull(peer, spring);
    peer.tau.setZero();
    for (const Torsion &torsion : peer.torsions)
        peer.tau[torsion.link] -= torsion.stiffness * (peer.q[torsion.link] - torsion.angle) +
                                  torsion.damping * peer.v[torsion.link];
}

} // namespace

extern "C" {

void *pinocchio_new(int links, const double *link, int springs, const double *spring, int torsions,
                    const double *torsion, double gravity, int world) {
    auto *peer = new Peer;
    peer->convention = world ? pin::Convention::WORLD : pin::Convention::LOCAL;
    peer->model.gravity.linear() = Vector3(0, 0, -gravity);
    for (int k = 0; k < links; k++) add_link(*peer, link, k);
    for (int k = 0; k < springs; k++, spring += SPRING_SIZE) {
        Spring made{{}, spring[6], spring[7], spring[8]};
        for (int end = 0; end < 2; end++) {
            const int on = static_cast<int>(spring[3 * end]);
            made.ends[end] = {static_cast<pin::JointIndex>(on + 1),
                              to_centre(link, on) + plane(spring[3 * end + 1], spring[3 * end + 2])};
        }
        peer->springs.push_back(made);
    }
    for (int k = 0; k < torsions; k++, torsion += TORSION_SIZE)
        peer->torsions.push_back(
            {static_cast<int>(torsion[0]), torsion[1], torsion[2], torsion[3]});
    peer->data = std::make_unique<pin::Data>(peer->model);
    peer->q = peer->v = peer->tau = Eigen::VectorXd::Zero(links);
    peer->acceleration.resize(links);
    peer->external.resize(links + 1, pin::Force::Zero());
    return peer;
}

void pinocchio_set(void *self, const double *x) {
    auto &peer = *static_cast<Peer *>(self);
    for (Eigen::Index k = 0; k < peer.q.size(); k++) {
        const int against = peer.turning[k];
        peer.q[k] = x[2 * k] - (against >= 0 ? x[2 * against] : 0.0);
        peer.v[k] = x[2 * k + 1] - (against >= 0 ? x[2 * against + 1] : 0.0);
    }
}

// The accelerations at the state set last, in Pinocchio's own coordinates: what is timed.
void pinocchio_evaluate(void *self, double, const double *, double *) {
    auto &peer = *static_cast<Peer *>(self);
    const View q(peer.q), v(peer.v), tau(peer.tau);
    if (peer.springs.empty() && peer.torsions.empty()) {
        pin::aba(peer.model, *peer.data, q, v, tau, peer.convention);
    } else {
        forces(peer);
        pin::aba(peer.model, *peer.data, q, v, tau, peer.external, peer.convention);
    }
}

void pinocchio_derivatives(void *self, double, const double *, double *) {
    auto &peer = *static_cast<Peer *>(self);
    const View q(peer.q), v(peer.v), tau(peer.tau);
    pin::computeABADerivatives(peer.model, *peer.data, q, v, tau);
}

void pinocchio_rates(void *self, double, const double *x, double *rates) {
    auto &peer = *static_cast<Peer *>(self);
    pinocchio_set(self, x);
    pinocchio_evaluate(self, 0.0, nullptr, nullptr);
    for (Eigen::Index k = 0; k < peer.q.size(); k++) {
        const int against = peer.turning[k];
        peer.acceleration[k] =
            peer.data->ddq[k] + (against >= 0 ? peer.acceleration[against] : 0.0);
        rates[2 * k] = x[2 * k + 1];
        rates[2 * k + 1] = peer.acceleration[k];
    }
}

void pinocchio_select(void *self) { selected = static_cast<Peer *>(self); }

// The selected peer as the rates of an integrator that knows no `self`.
void pinocchio_kernel(const double *t, const double *x, const double *, double *rates) {
    pinocchio_rates(selected, *t, x, rates);
}
}
