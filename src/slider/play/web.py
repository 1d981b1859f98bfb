"""MuJoCo's web viewer with a panel for the velocity, for machines without a display."""

# mujoco has no type stubs for its compiled part.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

import mujoco
from mujoco.studio import launch_thread, messages, plugin, viewer_protocol
from mujoco.studio.dear_imgui import dear_imgui as imgui
from mujoco.studio.web_viewer import WebViewer

from slider.config.robot import leg_scale
from slider.env.rollout import Frame
from slider.play import loop
from slider.play.loop import PUSH, Control
from slider.play.scenes import Scene
from slider.robot import names
from slider.robot.scene import aim, build_scene

_DISTANCE = 2.8  # of the camera from SLIDER [m]
_ONCE = 4  # ImGui: only when the window first appears
_SLIDERS = ("vx [m/s]", "vy [m/s]", "yaw rate [rad/s]")


class Panel(plugin.ViewerPlugin):
    """Sliders and buttons that write into a :class:`Control`; ``distance`` of the camera [m]."""

    def __init__(self, control: Control, distance: float) -> None:
        self._control, self._distance = control, distance
        self._followed: mujoco.MjModel | None = None
        self.status = ""

    @messages.handler
    def on_build_gui(self, event: messages.BuildGuiEvent) -> None:
        """Draw the panel."""
        model, viewed = self.viewer.model, self.viewer.camera
        if self._followed is not model and model.nbody > 1:  # once: the user may move it afterwards
            self._followed = model
            viewed.type = mujoco.mjtCamera.mjCAMERA_TRACKING
            viewed.trackbodyid = model.body(names.BASE).id
        control = self._control
        camera = control.take_camera()
        if camera is not None:
            aim(viewed, camera, self._distance)
        imgui.SetNextWindowPos(imgui.Vec2(10, 10), _ONCE)
        imgui.SetNextWindowSize(imgui.Vec2(330, 240), _ONCE)
        imgui.Begin("SLIDER")
        for line in self.status.split(", "):
            imgui.Text(line)
        for index, (name, limits) in enumerate(zip(_SLIDERS, control.limits, strict=True)):
            changed, value = imgui.SliderFloat(name, float(control.velocity[index]), *limits)
            if changed:
                control.set(index, value)
        actions = {
            "stand": control.stop,
            "push": lambda: control.push(0.0, PUSH),
            "resume" if control.paused else "pause": control.toggle_pause,
            "restart": control.restart,
            "camera": control.next_camera,
        }
        for index, (name, action) in enumerate(actions.items()):
            if index:
                imgui.SameLine()
            if imgui.Button(name):
                action()
        imgui.End()


def viewer_at(host: str) -> type[WebViewer]:
    """MuJoCo's viewer at one address; by default it listens at all addresses of the machine."""

    class Viewer(WebViewer):
        @property
        def _host(self) -> str:
            return host

        @_host.setter
        def _host(self, value: str) -> None:
            pass

    return Viewer


def run(scene: Scene, control: Control, seconds: float | None, host: str, port: int) -> None:
    """Serve the scene until interrupted."""
    model = build_scene(scene.robot)
    data = mujoco.MjData(model)
    config = viewer_protocol.ViewerConfig(title=scene.title, gfx="web", http_port=port)
    panel = Panel(control, _DISTANCE * leg_scale(scene.robot.geometry.leg_length))
    viewer_plugins, sim_plugins = plugin.split_plugins([panel])

    def serve(endpoint) -> None:
        viewer_protocol.run_viewer_loop(viewer_at(host)(config, endpoint, plugins=viewer_plugins))

    with launch_thread.launch_thread(serve, sim_plugins=sim_plugins) as handle:
        data.qpos[:] = scene.motion.start(control.velocity).qpos
        handle.set_model(model, data=data)

        def show(frame: Frame) -> bool:
            data.qpos[:] = frame.qpos
            data.time = frame.time
            mujoco.mj_forward(model, data)
            panel.status = loop.status(frame, control)
            handle.sync()
            return handle.is_running()

        try:
            loop.run(scene.motion, control, show, seconds)
        except KeyboardInterrupt:
            return
