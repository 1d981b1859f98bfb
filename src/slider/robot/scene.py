"""The robot in a scene for rendering: floor grid, sky, light with shadows, cameras."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

from itertools import pairwise
from typing import Any, NamedTuple

import mujoco
import numpy as np

from slider.config.robot import Geometry, RobotConfig
from slider.robot import names
from slider.robot.mjcf import SimulationOptions, build_spec

TILE = 0.5  # edge of a floor tile [m]
# Extent of the shadow map around the light [m]. With less, or with a light further away, the floor
# far behind the robot has speckles in the view of the front camera.
_EXTENT = 8.0
_TUBE = (0.12, 0.12, 0.13, 1.0)
# Viewing direction: azimuth about the vertical axis from +x, elevation (down: negative) [degree].
CAMERAS = {
    "side": (70.0, -10.0),  # from the right, slightly from behind: the floor shows depth
    "front": (180.0, -10.0),
}


def aim(camera: Any, name: str, distance: float) -> None:
    """Set direction (of ``CAMERAS``) and target distance [m] of a MuJoCo camera."""
    camera.azimuth, camera.elevation = CAMERAS[name]
    camera.distance = distance


class Relief(NamedTuple):
    """Heights of the ground on a grid, for rendering [m]."""

    heights: np.ndarray  # rows along y, columns along x
    x: tuple[float, float]  # x of the first and last column
    y: tuple[float, float]  # y of the first and last row


def build_scene(
    robot: RobotConfig, width: int = 640, height: int = 480, relief: Relief | None = None
) -> mujoco.MjModel:
    """Compile the robot with visual elements for rendering.

    ``width`` and ``height`` are the size of the offscreen buffer [pixel]; a ``relief`` replaces the
    flat floor.
    """
    spec = build_spec(robot, SimulationOptions())
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.quality.shadowsize = 2048
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.stat.extent = _EXTENT  # otherwise that of the floor, with a coarse shadow
    spec.visual.map.shadowclip = 1.0
    spec.visual.map.zfar = 40.0 / _EXTENT
    _add_textures(spec)
    if relief is not None:
        _raise_floor(spec, relief)
    spec.body(names.BASE).add_light(  # moves with the robot, so that its shadow stays sharp
        pos=[-0.2, -0.33, 1.0],
        dir=[0.2, 0.33, -1.0],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK,
        diffuse=[0.6, 0.6, 0.6],
        specular=[0.2, 0.2, 0.2],
        castshadow=True,
    )
    for side, lateral in zip(names.SIDES, (1.0, -1.0), strict=True):
        _complete_leg(spec, robot.geometry, side, lateral)
    return spec.compile()


def _add_textures(spec: mujoco.MjSpec) -> None:
    """Add textures of the sky and of the floor's tiles."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=(0.93, 0.95, 0.97),  # at the horizon
        rgb2=(0.62, 0.74, 0.88),
        width=256,
        height=1536,
    )
    spec.add_texture(
        name="tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        mark=mujoco.mjtMark.mjMARK_EDGE,
        rgb1=(0.80, 0.83, 0.86),
        rgb2=(0.70, 0.75, 0.80),
        markrgb=(0.55, 0.61, 0.67),
        width=512,
        height=512,
    )
    material = spec.add_material(name="tiles", texrepeat=[0.5 / TILE, 0.5 / TILE], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    material.specular = 0.0
    spec.geom(names.FLOOR).material = material.name


def _raise_floor(spec: mujoco.MjSpec, relief: Relief) -> None:
    heights, (left, right), (back, front) = relief.heights, relief.x, relief.y
    lowest, span = float(heights.min()), max(float(np.ptp(heights)), 1e-3)
    size = [0.5 * (right - left), 0.5 * (front - back), span, 0.1]
    rows, columns = heights.shape
    field = spec.add_hfield(name="ground", nrow=rows, ncol=columns, size=size)
    field.userdata = heights.ravel()  # MuJoCo maps the lowest to 0, the highest to 1
    floor = spec.geom(names.FLOOR)
    floor.type, floor.hfieldname = mujoco.mjtGeom.mjGEOM_HFIELD, field.name
    floor.pos = [0.5 * (left + right), 0.5 * (back + front), lowest]


def _complete_leg(spec: mujoco.MjSpec, geometry: Geometry, side: str, lateral: float) -> None:
    """Add parts that are only visual, since they never collide: ankle, links between hip axes."""
    *hip, _, ankle = geometry.leg(lateral)
    end, height = ankle.place, geometry.foot_radius - geometry.ankle_height
    lines = [(f"{side}_slide", geometry.tube_radius, [*end[:2], end[2] + 0.05, *end])]
    for above, joint in pairwise(hip):
        if joint.place.any():
            lines.append((f"{side}_{above.name}", 0.02, [0, 0, 0, *joint.place]))
    lines.append((names.foot(side), 0.011, [0, 0, 0, 0, 0, height]))
    for body, radius, line in lines:
        spec.body(body).add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[radius, 0, 0],
            fromto=line,
            rgba=_TUBE,
            mass=0.0,
            contype=0,
            conaffinity=0,
        )
