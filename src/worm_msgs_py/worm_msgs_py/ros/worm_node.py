"""The base of all our nodes: endpoints without what costs time and nobody needs."""

from collections import Counter
from collections.abc import Callable
from difflib import get_close_matches
from operator import attrgetter
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from worm_msgs_py import topics
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.limits import Limit
from worm_msgs_py.ros.qos import RESULT
from worm_msgs_py.ros.turn import Turn
from worm_msgs_py.text import printable

_LONGEST = 200

_OF_RCLPY = ("qos_overrides.", "use_sim_time", "start_type_description_service")


class WormNode(Node):
    """A node whose endpoints have no handlers of QoS events, and which has no parameter services.

    rclpy gives each publisher and subscription two handlers by default, which warn of a partner
    with another QoS. The executor builds all of them into every wait: with forty endpoints whose
    two sides are both ours that was a third of the graph's time. Where the partner is not ours,
    ask for the warning with ``event_callbacks=SubscriptionEventCallbacks()``.

    Attributes
    ----------
    ignored : Counter
        Messages that were not the graph's, by topic.
    STATE : tuple of str
        The attributes, dotted where they lie deeper, that tell all of what the node has taken and
        given so far: with them, another node of the same parameters goes on where this one is.
    """

    STATE: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: str, **node_arguments: Any) -> None:
        self.ignored: Counter[str] = Counter()
        self._complaints: Any = None
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

    def create_subscription(
        self,
        msg_type: type,
        topic: str,
        callback: Callable[[Any], None],
        qos_profile: QoSProfile,
        *,
        in_sequence: bool = False,
        **kwargs: Any,
    ) -> Any:
        """Create a subscription as rclpy does, without handlers of QoS events.

        What is not a message of the graph is counted and ignored: where the callback raises
        `MalformedMessage` (it must read the message before it does anything), or the message is out
        of sequence.

        Parameters
        ----------
        in_sequence : bool
            One publisher alone is ours on this topic: take its messages by the numbers that DDS
            gives each publisher's, none twice and none out of turn.
        """
        kwargs.setdefault(
            "event_callbacks", SubscriptionEventCallbacks(use_default_callbacks=False)
        )
        turn = Turn() if in_sequence else None

        def on_message(msg: Any, info: Any) -> None:
            number = info["publication_sequence_number"]
            if turn is not None and not turn.is_next(number):
                self._ignore(topic, f"number {number} of its publisher is out of turn")
                return
            try:
                callback(msg)
            except MalformedMessage as error:
                self._ignore(topic, str(error))
                if turn is not None:
                    turn.refused(number)
            else:
                if turn is not None:
                    turn.taken(number)

        return super().create_subscription(msg_type, topic, on_message, qos_profile, **kwargs)

    def _ignore(self, topic: str, why: str) -> None:
        """Count a message that is not ours; tell on `/diagnostics` at 1, 2, 4, 8, ..."""
        self.ignored[topic] += 1
        count = self.ignored[topic]
        if count & (count - 1):
            return
        if self._complaints is None:
            self._complaints = self.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, RESULT)
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN,
            name=f"{self.get_name()}: messages ignored",
            message=printable(f"{topic}: {why}")[:_LONGEST],
            values=[KeyValue(key=name, value=str(n)) for name, n in self.ignored.items()],
        )
        self._complaints.publish(DiagnosticArray(status=[status]))


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
