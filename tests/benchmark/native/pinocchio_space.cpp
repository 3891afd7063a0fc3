/* A chain of hinges or ball joints in space in Pinocchio: its ABA, in the form of loop.c. */
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/multibody.hpp>

#include <string>

namespace pin = pinocchio;
using View = Eigen::Ref<const Eigen::VectorXd>; // what the wheel's library is instantiated for

struct Chain {
    pin::Model model;
    pin::Data data;
    Eigen::VectorXd q, v, tau;
    bool balls;
    explicit Chain(const pin::Model &m)
        : model(m), data(m), q(m.nq), v(m.nv), tau(Eigen::VectorXd::Zero(m.nv)), balls(false) {}
};

/* Rows of `table`: axis (3), parent_to_joint (3), joint_to_child (3), mass, Ixx, Iyy, Izz, Ixy, Iyz,
   Izx. States: q and v of Pinocchio, one after the other. */
extern "C" void *pinocchio_space_new(int n, const double *table, int balls, double gravity) {
    pin::Model model;
    model.gravity.linear(Eigen::Vector3d(0, 0, -gravity));
    pin::JointIndex parent = 0;
    Eigen::Vector3d arm = Eigen::Vector3d::Zero();
    for (int k = 0; k < n; ++k, table += 16) {
        const Eigen::Map<const Eigen::Vector3d> axis(table), to(table + 3), out(table + 6);
        const pin::SE3 at(Eigen::Matrix3d::Identity(), arm + to);
        const std::string name = "joint" + std::to_string(k);
        if (balls)
            parent = model.addJoint(parent, pin::JointModelSpherical(), at, name);
        else
            parent = model.addJoint(
                parent, pin::JointModelRevoluteUnaligned(axis.normalized()), at, name);
        Eigen::Matrix3d J;
        const double *I = table + 10;
        J << I[0], I[3], I[5], I[3], I[1], I[4], I[5], I[4], I[2];
        model.appendBodyToJoint(parent, pin::Inertia(table[9], out, J), pin::SE3::Identity());
        arm = out;
    }
    Chain *chain = new Chain(model);
    chain->balls = balls;
    return chain;
}

static void accelerations(void *self, const double *x, double *result, pin::Convention convention) {
    Chain &c = *static_cast<Chain *>(self);
    c.q = Eigen::Map<const Eigen::VectorXd>(x, c.model.nq);
    c.v = Eigen::Map<const Eigen::VectorXd>(x + c.model.nq, c.model.nv);
    Eigen::Map<Eigen::VectorXd>(result, c.model.nv) =
        pin::aba(c.model, c.data, View(c.q), View(c.v), View(c.tau), convention);
}

extern "C" void pinocchio_space_local(void *self, double, const double *x, double *result) {
    accelerations(self, x, result, pin::Convention::LOCAL);
}

extern "C" void pinocchio_space_world(void *self, double, const double *x, double *result) {
    accelerations(self, x, result, pin::Convention::WORLD);
}

extern "C" int pinocchio_space_sizes(void *self, int velocities) {
    const Chain &c = *static_cast<Chain *>(self);
    return velocities ? c.model.nv : c.model.nq;
}
