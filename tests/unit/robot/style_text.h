// A robot as Menagerie writes them, for tests: MJCF in three files with nested default classes, degrees, a mesh folder,
// actuators of several kinds, a tendon that splits a force between two fingers, excludes and a keyframe.
#pragma once

#include <string>

#include "robot_text.h"

namespace primo::robot {

/// A model in three files, with what such models have: nested classes, degrees, a mesh folder, meshes to be seen beside
/// shapes to be felt, actuators of several kinds, a coupling tendon, excludes, a keyframe, sites as frames.
inline void write_model(const RobotFolder& folder, const std::string& coupling) {
  folder.put("defaults.xml", R"(<mujocoinclude><default>
    <default class="machine">
      <joint armature="0.1" damping="1"/>
      <default class="elbowlike"><joint axis="0 1 0" range="-120 120" limited="true"/></default>
      <default class="jaw"><joint type="slide" axis="0 1 0" limited="true" range="0 0.04" armature="0.1"/></default>
      <default class="seen"><geom type="mesh" group="2" contype="0" conaffinity="0" mass="0"/></default>
      <default class="felt"><geom group="3" type="capsule" size="0.04"/></default>
    </default></default></mujocoinclude>)");
  folder.put("hand.xml", R"(<mujocoinclude>
    <body name="hand" pos="0 0 0.1" euler="0 0 -45" childclass="machine">
      <geom class="felt" type="box" size="0.03 0.1 0.03" pos="0 0 0.03"/>
      <site name="centre" pos="0 0 0.1" euler="0 0 90"/>
      <body name="one" pos="0 0 0.06"><joint name="one" class="jaw"/>
        <geom class="felt" type="box" size="0.01 0.01 0.025" pos="0 0.01 0.02"/></body>
      <body name="two" pos="0 0 0.06" euler="0 0 180"><joint name="two" class="jaw"/>
        <geom class="felt" type="box" size="0.01 0.01 0.025" pos="0 0.01 0.02"/></body>
    </body></mujocoinclude>)");
  folder.put("meshes/wedge.obj", "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  folder.put("robot.xml", R"(<mujoco model="style">
    <compiler angle="degree" meshdir="meshes"/>
    <option integrator="RK4" timestep="0.01" gravity="0 0 0"/>
    <size nkey="2"/>
    <include file="defaults.xml"/>
    <asset><mesh name="wedge" file="wedge.obj"/></asset>
    <worldbody><body name="foot" pos="0.1 0 0.5" childclass="machine">
      <geom class="seen" mesh="wedge"/><geom class="felt" fromto="0 0 0 0 0 0.2"/>
      <body name="l1" pos="0 0 0.25"><joint name="q1" axis="0 0 1" limited="true" range="-170 170"/>
        <geom class="felt" fromto="0 0 0 0 0 0.3"/><geom class="seen" mesh="wedge"/>
        <body name="l2" pos="0 0 0.3" euler="10 0 0"><joint name="q2" class="elbowlike" ref="20"/>
          <geom class="felt" fromto="0 0 0 0 0 0.3"/>
          <body name="l3" pos="0 0 0.3"><joint name="q3" class="elbowlike" pos="0.01 0 0"/>
            <geom class="felt" fromto="0 0 0 0 0 0.1"/>
            <include file="hand.xml"/>
          </body></body></body></body></worldbody>
    <contact><exclude body1="hand" body2="one"/></contact>
    <tendon><fixed name="split"><joint joint="one" coef="0.5"/><joint joint="two" coef="0.5"/></fixed>
      <fixed name="jaw_one"><joint joint="one" coef="1"/></fixed>
      <fixed name="jaw_two"><joint joint="two" coef="2"/></fixed>
      <fixed name="difference"><joint joint="one" coef="1"/><joint joint="two" coef="-1"/></fixed></tendon>
    <equality>)" + coupling + R"(</equality>
    <actuator><position name="q1" joint="q1" kp="100"/><motor name="q2" joint="q2"/>
      <general name="jaws" tendon="split" biastype="affine" gainprm="100" biasprm="0 -100 -10"/></actuator>
    <sensor><jointpos joint="q1"/><actuatorfrc actuator="jaws"/></sensor>
    <keyframe><key name="home" qpos="0 0.3 0.4 0.04 0.04"/></keyframe></mujoco>)");
  folder.put("robot.yaml", R"(name: style
mjcf: robot.xml
arm: [{joint: q1}, {joint: q2, home: 0.3}, {joint: q3, home: 0.4}]
hand: [{joint: one, home: 0.04, closing: -20, kp: 1000, kd: 10, max_torque: 40}]
grasp_frame: {site: centre}
fingertips:
  - {name: one, frame: {body: one, position: [0, 0, 0.03], rpy: [1.5707963267948966, 0, 0]}}
  - {name: two, frame: {body: two, position: [0, 0, 0.03], rpy: [1.5707963267948966, 0, 0]}}
)");
}

inline const char* const kJaws = R"(<joint joint1="two" joint2="one"/>)";

}  // namespace primo::robot
