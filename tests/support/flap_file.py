"""A model file with every kind of load and table, and the table beside it (wave.csv)."""

TEXT = """\
name: flap
parameters:
  k: {value: 100, unit: N/m}
  c: {value: 5, unit: kg/m}
tables:
  gust: {times: [0, 1, 2.5], values: [0, 0.4, 0], unit: kN, description: Wind}
  wave: {file: wave.csv, columns: [time, height]}
bodies:
  hull: {mass: 5, inertia: 1}
  flap: {mass: 2, inertia: 1}
joints:
  sea: {type: floating, child: hull}
  hinge: {type: revolute, parent: hull, child: flap, joint_to_child: [0, -1], coordinate: relative}
points:
  tip: {body: flap, at: [0, -1]}
  wall: {body: ground, at: [9, 0]}
loads:
  rope: {type: tension_spring, points: [tip, wall], length: 3, law: k*l + 2*ld}
  valve: {type: tension_damper, points: [tip, wall], law: 3*abs(ld)*ld}
  slack: {type: tension_stop, points: [tip, wall], stiffness: k, upper: 8}
  coil: {type: torsion_spring, bodies: [hull, flap], law: sin(theta)}
  oil: {type: torsion_damper, bodies: [hull, flap], law: tanh(thetad)}
  blow: {type: point_force, point: tip, force: [gust, 0], axes: body}
  lift: {type: body_force, body: hull, force: [0, -k*body.hull.z], moment: wave}
  sail: {type: point_drag, point: tip, coefficient: c, flow: [point.tip.vx/2, 0]}
  keel: {type: body_drag, body: hull, coefficient: c, moment_coefficient: 2}
  motor: {type: joint_effort, joint: hinge, effort: -3*joint.hinge.u}
  rub: {type: joint_friction, joint: hinge, effort: 2, velocity: 0.01}
  end: {type: joint_stop, joint: hinge, stiffness: 90, lower: -pi/2, upper: pi/2, damping: 3}
"""
WAVE = "time, force, height\n0, 7, 1.5\n2, 8, -1.5\n\n5.5, 9, 0\n"
