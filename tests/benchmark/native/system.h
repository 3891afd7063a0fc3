/* A planar system in neutral form (systems.py): rows of `links` are parent, revolute,
   parent_to_joint x z, joint_to_child x z, direction x z, mass, inertia; of `springs` first, point
   x z, second, point x z, stiffness, length, damping; of `torsions` link, stiffness, angle,
   damping. The state x is q and u of each link in turn, angles absolute. */
#ifndef SYSTEM_H
#define SYSTEM_H

enum { LINK_SIZE = 10, SPRING_SIZE = 9, TORSION_SIZE = 4 };
enum { PARENT, REVOLUTE, PARENT_X, PARENT_Z, CHILD_X, CHILD_Z, DIRECTION_X, DIRECTION_Z, MASS,
       INERTIA };

#endif
