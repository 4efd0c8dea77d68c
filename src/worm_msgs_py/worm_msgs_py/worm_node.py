"""The base of all our nodes: endpoints without what costs time and nobody needs."""

from difflib import get_close_matches
from operator import attrgetter
from typing import Any, ClassVar

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter

from worm_msgs_py.errors import BadInput
from worm_msgs_py.limits import Limit

_OF_RCLPY = ("qos_overrides.", "use_sim_time", "start_type_description_service")


class WormNode(Node):
    """A node whose endpoints have no handlers of QoS events, and which has no parameter services.

    rclpy gives each publisher and subscription two handlers by default, which warn of a partner
    with another QoS. The executor builds all of them into every wait: with forty endpoints whose
    two sides are both ours that was a third of the graph's time. Where the partner is not ours,
    ask for the warning with ``event_callbacks=SubscriptionEventCallbacks()``.

    Attributes
    ----------
    STATE : tuple of str
        The attributes, dotted where they lie deeper, that tell all of what the node has taken and
        given so far: with them, another node of the same parameters goes on where this one is.
    """

    STATE: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: str, **node_arguments: Any) -> None:
        super().__init__(name, start_parameter_services=False, **node_arguments)

    def read_parameter(
        self,
        name: str,
        default: Any,
        description: str,
        limit: Limit | None = None,
        *,
        or_else: float | None = None,
    ) -> Any:
        """Declare a parameter that is read once, with what it is for; return its value.

        Parameters
        ----------
        default
            Its type is the parameter's; may be a `rclpy.parameter.Parameter.Type` where there is no
            sensible one. A whole number is taken where the default is a float, as YAML writes it.
        limit : Limit, optional
            What it may be.
        or_else : float, optional
            A value beyond the limit that has a meaning of its own.

        Raises
        ------
        BadInput
            It is out of its limits.
        """
        given = self._parameter_overrides.get(name)
        if given is not None and isinstance(default, float) and type(given.value) is int:
            self._parameter_overrides[name] = Parameter(name, value=float(given.value))
        descriptor = ParameterDescriptor(description=description, read_only=True)
        value = self.declare_parameter(name, default, descriptor).value
        wrong = "" if limit is None or value == or_else else limit.refusal(value)
        if wrong:
            raise BadInput(f"node {self.get_name()}: {name} {wrong}")
        return value

    def checkpoint(self) -> dict[str, Any]:
        """Return the node's state, which can be pickled; take it between callbacks."""
        return {name: attrgetter(name)(self) for name in self.STATE}

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a state that `checkpoint` gave, before the first message is taken."""
        for name, value in state.items():
            owner, _, last = name.rpartition(".")
            setattr(attrgetter(owner)(self) if owner else self, last, value)

    def create_publisher(self, *args: Any, **kwargs: Any) -> Any:
        """Create a publisher as rclpy does, without handlers of QoS events."""
        kwargs.setdefault("event_callbacks", PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(*args, **kwargs)

    def create_subscription(self, *args: Any, **kwargs: Any) -> Any:
        """Create a subscription as rclpy does, without handlers of QoS events."""
        kwargs.setdefault(
            "event_callbacks", SubscriptionEventCallbacks(use_default_callbacks=False)
        )
        return super().create_subscription(*args, **kwargs)


def refuse_unknown_parameters(node: Node) -> None:
    """Refuse a parameter that was given and is not declared: rclpy passes over it silently.

    Raises
    ------
    BadInput
        Names the first of them, and the declared one that is most like it.
    """
    known = sorted(set(node._parameters) - {"use_sim_time"})
    for name in node._parameter_overrides:
        if name in node._parameters or name.startswith(_OF_RCLPY):
            continue
        like = get_close_matches(name, known, n=1)
        guess = f"did you mean {like[0]!r}? " if like else ""
        raise BadInput(
            f"node {node.get_name()} has no parameter {name!r}: {guess}it has {', '.join(known)}"
        )
