"""Write docs/nodes.md: topics, services and parameters of every node, from nodes that run.

python docs/make_nodes.py
"""

import inspect
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from worm_bringup.graph.node_spec import NodeSpec, node_class
from worm_bringup.graph.nodes import NODES, ROS_NAMES
from worm_bringup.graph.ros_environment import own_context
from worm_msgs_py.declarations import Declaration
from worm_msgs_py.ros.worm_node import WormNode

BAG = Path(__file__).parents[1] / "bags" / "larva"
HEAD = """# Nodes

Topics, services and parameters of every node. A node's name on the command line is the heading
here: `worm node tracker --ros-args -p radius_m:=0.01 -r __ns:=/rig1 --params-file rig.yaml` runs
one alone, as `ros2 run worm_tracker tracker` does on a full ROS 2 installation. Topics are
relative, so that a namespace applies, but for `/diagnostics`.

Each parameter is checked before the node does anything, whichever way it is started: a wrong type,
a value out of range and a name that no parameter has are refused in a line (exit status 2). Where
others can see the graph (`worm live`, `worm replay --visible`, a node alone) every node has ROS's
own parameter services, and refuses at `set` with the same line as the reason. In a graph that keeps
to itself nobody could call them, and they are off.

**fixed** parameters are read once. What the results rest on is fixed: a number that was measured
under two contact rules, two radii or two windows is neither's. **live** ones may change while the
node runs, and each change but a seek is told in `summary.json` under `source_events`: node, name,
from, to, and the frame and stamp from which it holds. A replay is as deterministic as before:
nothing changes by itself.

`~/set_rate` and `~/seek` of rosbag2 are the parameters `rate` and `seek_to`: no standard service
carries a number. The tracker links each picture to the one before, and every number rests on all
frames up to it, so a seek leaves nothing out: it plays as fast as the graph can take it as far as
the place that is sought, and pauses there. Like `~/pause` it changes no result and is not told
there; what has been played cannot be sought (the monitor's page shows it, by its own picture and
pose). A part of a recording is chosen by `start_offset` and `playback_duration`, which stand in the
results.

This page is made by `python docs/make_nodes.py`.
"""


@contextmanager
def running_nodes() -> Iterator[dict[str, WormNode]]:
    """Give every node by its name for `worm node`, each in a namespace of that name."""
    with TemporaryDirectory() as folder, own_context() as context, ExitStack() as stack:
        nodes = {}
        for name, parameters in enough_to_run(Path(folder)).items():
            spec = NodeSpec(NODES[name], ROS_NAMES.get(name, name), parameters)
            node = spec.make(context=context, namespace=f"/{name}", served=True)
            assert isinstance(node, WormNode)
            nodes[name] = node
            stack.callback(nodes[name].destroy_node)
        yield nodes


def enough_to_run(folder: Path) -> dict[str, dict[str, object]]:
    """Return the parameters that each node cannot do without, with files for them in a folder."""
    film = folder / "film.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter_fourcc(*"MJPG"), 25.0, (64, 64), False)
    writer.write(np.zeros((64, 64), np.uint8))
    writer.release()
    (folder / "out").mkdir()
    needed: dict[str, dict[str, object]] = {name: {} for name in NODES}
    needed["replay"] = {"bag": str(BAG)}
    needed["camera"] = {"camera": str(film)}
    needed["simulated_camera"] = {"camera": "sim"}
    needed["recorder"] = {"out": str(folder / "out")}
    needed["foxglove"] = {"port": 0}
    return needed


def page() -> str:
    """Return the page."""
    with running_nodes() as nodes:
        return "\n".join([HEAD, *(_section(name, node) for name, node in nodes.items())])


def _section(name: str, node: WormNode) -> str:
    said = (inspect.getdoc(node_class(NODES[name])) or "").partition("\n")[0]
    parts = [f"## {name}", f"Node `{node.get_name()}`, module `{NODES[name]}`. {said}"]
    parts.append(_table("publishes", (_topic(node, it) for it in node.publishers)))
    parts.append(_table("subscribes", (_topic(node, it) for it in node.subscriptions)))
    parts.append(_services(node))
    rows = (_parameter(declared) for declared in node.PARAMETERS)
    parts.append(_table("parameter | default | unit | range | live or fixed", rows, "what it is"))
    return "\n\n".join(part for part in parts if part) + "\n"


def _table(head: str, rows: Iterable[str], last: str = "type | QoS") -> str:
    cells = [head, *last.split(" | ")]
    head = " | ".join(cells)
    listed = sorted({row for row in rows if row}) if last == "type | QoS" else list(rows)
    if not listed:
        return ""
    rule = "|".join(["---"] * (head.count("|") + 1))
    return "\n".join([f"| {head} |", f"|{rule}|", *listed])


def _topic(node: WormNode, endpoint: object) -> str:
    topic = str(endpoint.topic_name)
    if topic in ("/rosout", "/parameter_events", "/clock"):
        return ""
    name = topic.removeprefix(f"{node.get_namespace()}/")
    return f"| `{name}` | {_type(endpoint.msg_type)} | {_qos(endpoint.qos_profile)} |"


def _type(kind: type) -> str:
    return f"{kind.__module__.partition('.')[0]}/{kind.__name__}"


def _qos(qos: QoSProfile) -> str:
    reliable = qos.reliability is ReliabilityPolicy.RELIABLE
    latched = qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
    said = ["reliable" if reliable else "best effort", *(["latched"] if latched else [])]
    return f"{', '.join(said)}, the last {qos.depth}"


def _services(node: WormNode) -> str:
    found = sorted(
        f"`{service.srv_name}` ({_type(service.srv_type)})"
        for service in node.services
        if not _type(service.srv_type).startswith(("rcl_interfaces", "type_description"))
    )
    return f"Services: {', '.join(found)}." if found else ""


def _parameter(declared: Declaration) -> str:
    default = declared.default
    shown = ", ".join(default) if isinstance(default, list) else str(default)
    cells = [
        f"`{declared.name}`",
        f"`{shown.lower() if isinstance(default, bool) else shown}`" if shown else "–",
        declared.unit or "–",
        declared.allowed,
        "live" if declared.changes else "fixed",
        declared.description.replace("|", "\\|"),
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    Path(__file__).with_name("nodes.md").write_text(page(), encoding="utf-8")
