"""Drake as a second physics engine, with the interface of ``BatchedPhysics``.

Drake computes the motion, the contact forces and, once per Drake step, the position loops. MuJoCo's
kinematics turn each state into the readings of its sensors, so that controllers, estimator,
terminations and metrics are the same code for both engines.
"""

# mujoco has no type stubs for its compiled part; drake is optional.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from collections.abc import Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from slider.config.convert import from_dict
from slider.config.evaluation import DrakeContact
from slider.core.errors import require
from slider.env.disturbance import Disturbance, has_terrain
from slider.env.physics import BatchedPhysics
from slider.env.randomization import vary
from slider.robot import names
from slider.robot.drake import Motors, add_drives, add_robot
from slider.robot.kinematics import rotation_from_quaternion


class DrakeRobot:
    """One robot in Drake; positions (19,) and velocities (18,) are those of MuJoCo.

    Attributes:
        plant, context: Drake's model and its state.
    """

    def __init__(self, model: mujoco.MjModel, timestep: float, contact: DrakeContact) -> None:
        builder = DiagramBuilder()
        self.plant = add_robot(builder, model, timestep, contact)
        motors = Motors.of(model)
        inputs, self._torques = add_drives(builder, self.plant, motors)
        builder.ExportInput(inputs)
        diagram = builder.Build()
        self._simulator, self._inputs = Simulator(diagram), diagram.get_input_port()
        self._root = self._simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self._root)
        self._drives = self._torques.get_system().GetMyContextFromRoot(self._root)
        self._results = self.plant.get_contact_results_output_port()
        self._feet = [self.plant.GetBodyByName(names.foot(side)).index() for side in names.SIDES]
        self._timestep, self._steps = timestep, 0
        self._inputs.FixValue(self._root, np.zeros(len(motors.kp)))
        self._simulator.Initialize()

    def place(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        """Set positions and velocities."""
        turn = rotation_from_quaternion(qpos[None, 3:7])[0]
        state = [qpos[3:7], qpos[:3], qpos[7:], turn @ qvel[3:6], qvel[:3], qvel[6:]]
        self.plant.SetPositionsAndVelocities(self.context, np.concatenate(state))

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities."""
        state = self.plant.GetPositionsAndVelocities(self.context)
        q, v = state[: self.plant.num_positions()], state[self.plant.num_positions() :]
        quaternion = q[:4] / np.linalg.norm(q[:4])
        spin = v[:3] @ rotation_from_quaternion(quaternion[None])[0]
        return np.concatenate([q[4:7], quaternion, q[7:]]), np.concatenate([v[3:6], spin, v[6:]])

    def torques(self, inputs: np.ndarray) -> np.ndarray:
        """Motor torques (10,) [N m] that inputs (10,) demand in this state."""
        self._inputs.FixValue(self._root, inputs)
        return self._torques.Eval(self._drives)

    def advance(self, inputs: np.ndarray, steps: int) -> np.ndarray:
        """Simulate steps with constant inputs (10,); return mean start-end torques (10,) [N m].

        Raises:
            RuntimeError: Drake's solver does not converge.
        """
        first = self.torques(inputs)
        self._steps += steps
        self._simulator.AdvanceTo(self._steps * self._timestep, interruptible=False)
        return 0.5 * (first + self._torques.Eval(self._drives))

    def foot_forces(self) -> np.ndarray:
        """Vertical ground reactions (2,) [N] in the last step."""
        forces, results = np.zeros(len(self._feet)), self._results.Eval(self.context)
        for index in range(results.num_point_pair_contacts()):
            contact: Any = results.point_pair_contact_info(index)
            pair = contact.bodyA_index(), contact.bodyB_index()
            for foot, body in enumerate(self._feet):
                if body in pair and self.plant.world_body().index() in pair:
                    forces[foot] += abs(contact.contact_force()[2])
        return forces


class DrakePhysics(BatchedPhysics):
    """Steps ``num_robots`` nominal robots on flat ground, one after the other.

    ``drake`` has ``timestep`` [s], which divides MuJoCo's, and ``contact``. Other arguments are
    those of ``BatchedPhysics``.

    Raises:
        UserError: the robots differ, are pushed, or are on uneven ground.
    """

    def __init__(
        self,
        *args: Any,
        drake: Mapping[str, Any],
        disturbance: Disturbance | None = None,
        **settings: Any,
    ) -> None:
        super().__init__(*args, disturbance=disturbance, **settings)
        if disturbance is not None:
            config, expected = disturbance.config, "nominal robots on flat ground, not pushed"
            others = vary(config) or has_terrain(config) or config.push.impulse.upper > 0
            require(not others, "Drake: disturbance", expected, "others")
        contact = from_dict(DrakeContact, drake["contact"])
        self._build = partial(DrakeRobot, self.model, drake["timestep"], contact)
        self._robot, self._timestep = self._build(), self.model.opt.timestep
        self._ratio = round(self._timestep / drake["timestep"])

    def _simulate(self, control: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States (N, S, 38) and sensors (N, S, sensors) after each of S steps of MuJoCo's length.

        Torques are means over a step; foot forces are those of the last Drake step in it.
        """
        states = np.repeat(self.state[:, None], self._substeps, axis=1)
        sensors = np.repeat(self._sensors[:, None], self._substeps, axis=1)
        for index in np.flatnonzero(~self._inactive):
            self._robot.place(self.qpos[index], self.qvel[index])
            for step, inputs in enumerate(control[index]):
                try:
                    torques = self._robot.advance(inputs, self._ratio)
                except RuntimeError:  # handled like a diverged MuJoCo simulation
                    states[index, step:] = np.nan
                    self._robot = self._build()
                    break
                states[index, step, 0] += (step + 1) * self._timestep
                states[index, step, 1:] = np.concatenate(self._robot.state())
                sensors[index, step] = self._sense(states[index, step], torques)
        return states, sensors

    def _sense(self, state: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Readings of MuJoCo's sensors in a state, with Drake's torques and foot forces."""
        data, index = self._data[0], self._index
        data.qpos[:], data.qvel[:] = state[1 : 1 + self.model.nq], state[1 + self.model.nq :]
        mujoco.mj_forward(self.model, data)
        sensors = data.sensordata.copy()
        sensors[index.torques], sensors[index.forces] = torques, self._robot.foot_forces()
        return sensors

    def _drive(self) -> tuple[np.ndarray, np.ndarray]:
        states, sensors = self._series
        speeds = self._motors.angles(states[:, :, -names.NUM_JOINTS :])
        return sensors.take(self._index.torques, 2), speeds
