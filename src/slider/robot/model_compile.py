"""Compile a model file (MJCF or URDF) with MuJoCo, without parts that an import does not need.

Files may lack masses or meshes. Repaired and dropped parts are reported.
"""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false

import re
from pathlib import Path

import mujoco
import numpy as np

from slider.core.errors import UserError, require
from slider.robot.model_foot import prepare_feet
from slider.robot.model_motors import urdf_speeds
from slider.robot.model_tree import Roles


def compiled(path: Path, roles: Roles) -> tuple[mujoco.MjModel, list[str], dict[str, float]]:
    """Model without sensors and meshes (except of feet); remarks on losses; a URDF's speed limits.

    Raises:
        UserError: MuJoCo cannot read the file, or a mass or an inertia of a leg is missing.
    """
    require(path.is_file(), "robot.model", "a model file (MJCF or URDF)", f"none at {path}")
    warn, warnings = mujoco.get_mju_user_warning(), []
    mujoco.set_mju_user_warning(warnings.append)  # the default is a file in the working directory
    content = path.read_bytes()
    bare = re.sub(rb"(?s)<!--.*?-->", b"", content)
    expected = f"a URDF or MJCF: first run `xacro {path.name} > robot.urdf`"
    require(b"<xacro:" not in bare, "robot.model", expected, f"xacro in {path.name}")
    first = re.search(rb"<(\w+)", bare)  # by which MuJoCo recognises the format, too
    urdf = first is not None and first[1] == b"robot"
    try:
        spec = _read(path, content)
        meshes = prepare_feet(spec, set(roles.joints.get("ankle") or ()), path.parent)
        try:
            told = _strip(spec, urdf, roles, meshes)
            model = spec.compile()
        except ValueError:
            if not meshes:
                raise
            spec = _read(path, content)
            told = [*_strip(spec, urdf, roles, set()), "meshes of the feet cannot be read"]
            model = spec.compile()
    except (ValueError, OSError) as error:
        text = " ".join([*str(error).split(), *" ".join(warnings).split()])
        raise UserError(f"robot.model: {path.name}: {text}") from None
    finally:
        mujoco.set_mju_user_warning(warn)
    finite = np.isfinite(model.body_mass).all() and np.isfinite(model.body_inertia).all()
    require(bool(finite), "robot.model", "finite masses and inertias", "others")
    return model, told, urdf_speeds(content) if urdf else {}


def _read(path: Path, content: bytes) -> mujoco.MjSpec:
    """Specification of a file, whose name may have any suffix."""
    if path.suffix in (".xml", ".urdf"):
        return mujoco.MjSpec.from_file(str(path))
    return mujoco.MjSpec.from_string(content.decode())


def _strip(spec: mujoco.MjSpec, urdf: bool, roles: Roles, meshes: set[str]) -> list[str]:
    """Delete parts that need other files or refer to deleted parts; repair masses, inertias."""
    geoms, expected = mujoco.mjtGeom, "masses of inertial elements"
    from_geoms = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    require(not from_geoms, "robot.model", expected, 'inertiafromgeom="true"')
    led = {name for pair in roles.joints.values() for name in pair or ()}
    for part in [*spec.geoms, *spec.sites, *spec.tendons]:
        part.material = ""
    bare, broken = {}, []
    for geom in list(spec.geoms):
        body = geom.parent
        shaped = geom.type in (geoms.mjGEOM_MESH, geoms.mjGEOM_HFIELD)
        weightless = geom.mass == 0.0 or (np.isnan(geom.mass) and geom.density == 0.0)
        own = body.explicitinertial or body == spec.worldbody or weightless
        if not own and urdf and led.isdisjoint(joint.name for joint in body.joints):
            bare[body.name] = geom.density = 0.0  # as the format specifies
            own = True
        weighs = own or not (shaped or urdf)
        require(weighs, "robot.model", f"{expected} in bodies", f"{body.name} without")
        if shaped and geom.meshname not in meshes:
            spec.delete(geom)
        elif shaped:
            geom.mass = 0.0
    for body in spec.bodies[1:]:
        weight = body.mass if body.explicitinertial else sum(g.mass != 0.0 for g in body.geoms)
        moves = list(body.joints)
        if moves and not weight:
            body.mass, body.explicitinertial = 1e-9, True
        elif led.isdisjoint(joint.name for joint in moves) and not _is_rigid(body):
            broken.append(body.name)
        else:
            continue
        body.fullinertia, body.inertia = [np.nan] * 6, [1e-12] * 3
    acts = [act for act in spec.actuators if act.target not in led or act.plugin.active]
    parts = [*spec.sensors, *acts, *spec.keys, *spec.pairs, *spec.excludes, *spec.skins]
    rest = [mesh for mesh in spec.meshes if mesh.name not in meshes]
    for part in [*parts, *rest, *spec.hfields, *spec.materials, *spec.textures]:
        spec.delete(part)
    spec.compiler.fusestatic = False  # otherwise the root of a URDF is merged into the world
    causes = {
        "no inertial element, so no mass": bare,
        "impossible inertia, so a point mass": broken,
    }
    return [f"{cause}: {', '.join(names)}" for cause, names in causes.items() if names]


def _is_rigid(body: mujoco.MjsBody) -> bool:
    """Whether the moments of inertia that the file specifies for a body are physically possible."""
    moments, full = np.array(body.inertia), body.fullinertia
    if not body.explicitinertial:
        return True
    if not np.isnan(full[0]):
        (xx, yy, zz), (xy, xz, yz) = full[:3], full[3:]
        moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return moments.min() >= 0.0 and 2 * moments.max() <= moments.sum() * (1 + 1e-9) + 1e-12
