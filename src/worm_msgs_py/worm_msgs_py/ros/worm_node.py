"""The base of all our nodes: endpoints without what costs time and nobody needs."""

from collections import Counter
from collections.abc import Callable
from operator import attrgetter
from typing import Any, ClassVar, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from worm_msgs_py import topics
from worm_msgs_py.declarations import Declaration, declarations
from worm_msgs_py.errors import BadInput, MalformedMessage
from worm_msgs_py.ros.parameter_files import for_others
from worm_msgs_py.ros.parameters import FIXED, descriptor, of_its_kind, unknown_parameter
from worm_msgs_py.ros.publisher_sequence import PublisherSequence
from worm_msgs_py.ros.qos import RESULT
from worm_msgs_py.text import printable

_LONGEST_WARNING = 200

_OF_RCLPY = ("qos_overrides.", "use_sim_time", "start_type_description_service")

Parameters = TypeVar("Parameters")


class WormNode(Node):
    """A node whose endpoints have no handlers of QoS events, and whose parameters are checked.

    rclpy gives each publisher and subscription two handlers by default, which warn of a partner
    with another QoS. The executor builds all of them into every wait: with forty endpoints whose
    two sides are both ours that was a third of the graph's time. Where the partner is not ours,
    ask for the warning with ``event_callbacks=SubscriptionEventCallbacks()``.

    Attributes
    ----------
    ignored : Counter
        Messages that were not the graph's, by topic.
    PARAMETERS : tuple of Declaration
        All that the node may be told; it has them, checked, before its own constructor goes on.
    STATE : tuple of str
        The attributes, dotted where they lie deeper, that tell all of what the node has taken and
        given so far: with them, another node of the same parameters goes on where this one is.
    """

    STATE: ClassVar[tuple[str, ...]] = ()
    PARAMETERS: ClassVar[tuple[Declaration, ...]] = ()

    def __init__(self, name: str, **node_arguments: Any) -> None:
        self.ignored: Counter[str] = Counter()
        self._complaints: Any = None
        self._declared = {declared.name: declared for declared in self.PARAMETERS}
        self._values: dict[str, Any] = {}
        self._heard: list[tuple[Any, Callable[[Any, Any], None]]] = []
        super().__init__(name, **node_arguments)
        try:
            for declared in self.PARAMETERS:
                self._declare(declared)
            if self.PARAMETERS:
                refuse_unknown_parameters(self)
        except BaseException:
            super().destroy_node()  # a node's own destroys what there is not yet
            raise

    def _declare(self, declared: Declaration) -> None:
        """Declare a parameter with what is given for it, once that is found right."""
        name = declared.name
        given = self._parameter_overrides.get(name)
        if given is None:
            value = declared.default
        else:
            wrong = declared.refusal(given.value)
            if wrong:
                raise BadInput(f"node {self.get_name()}: {name} {wrong}")
            value = of_its_kind(given, declared).value
        self._values[name] = value
        shown = value if declared.shown is None else declared.shown(value)
        self.declare_parameter(name, shown, descriptor(declared), ignore_override=True)

    def read_parameter(self, name: str) -> Any:
        """Return the value of a parameter that is among `PARAMETERS`."""
        return self._values[name]

    def read_parameters(self, kind: type[Parameters]) -> Parameters:
        """Return the dataclass whose fields are parameters of this node (see `declarations`)."""
        return kind(
            **{declared.name: self._values[declared.name] for declared in declarations(kind)}
        )

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set parameters one by one, as `set_parameters_atomically` does."""
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all or none; a refusal says why in a line, where rclpy raises or says less."""
        for parameter in parameter_list:
            wrong = self._refusal_to_set(parameter)
            if wrong:
                return SetParametersResult(successful=False, reason=wrong)
        kept = [
            of_its_kind(parameter, self._declared[parameter.name])
            if parameter.name in self._declared
            else parameter
            for parameter in parameter_list
        ]
        result = super().set_parameters_atomically(kept)
        for parameter in kept if result.successful else []:
            before = self._values.get(parameter.name)
            if parameter.name in self._declared and before != parameter.value:
                self._values[parameter.name] = parameter.value
                self.take_change(parameter.name, before, parameter.value)
        return result

    def _refusal_to_set(self, parameter: Parameter) -> str:
        declared = self._declared.get(parameter.name)
        if declared is None:
            known = parameter.name in self._parameters
            return (
                "" if known else unknown_parameter(self.get_name(), parameter.name, self._declared)
            )
        wrong = declared.refusal(parameter.value) or ("" if declared.changes else FIXED)
        return f"{parameter.name} {wrong}" if wrong else self.why_no_change(parameter)

    def why_no_change(self, parameter: Parameter) -> str:
        """Return why a parameter may not be so changed at this time; empty where it may."""
        return ""

    def take_change(self, name: str, before: Any, value: Any) -> None:
        """Take a parameter's new value, and see that the results tell of it."""

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
        sequence = PublisherSequence() if in_sequence else None

        def on_message(msg: Any, info: Any) -> None:
            number = info["publication_sequence_number"]
            if sequence is not None and not sequence.is_next(number):
                self._ignore(topic, f"number {number} of its publisher is out of turn")
                return
            try:
                callback(msg)
            except MalformedMessage as error:
                self._ignore(topic, str(error))
                if sequence is not None:
                    sequence.refused(number)
            else:
                if sequence is not None:
                    sequence.taken(number)

        heard = super().create_subscription(msg_type, topic, on_message, qos_profile, **kwargs)
        self._heard.append((heard, on_message))
        return heard

    def destroy_subscription(self, subscription: Any) -> bool:
        """Destroy a subscription as rclpy does."""
        self._heard = [heard for heard in self._heard if heard[0] is not subscription]
        return bool(super().destroy_subscription(subscription))

    def take_messages(self) -> bool:
        """Take a message from each subscription that has one; return whether any had.

        Not through an executor, which for each round builds a set of all endpoints to wait for,
        and for each message a task and three wake-ups: with forty endpoints a fifth of the graph's
        time. Only for the thread that spins the node, between its callbacks.
        """
        any_taken = False
        for subscription, on_message in tuple(self._heard):
            handle = subscription.handle
            try:
                with handle:
                    taken = handle.take_message(subscription.msg_type, subscription.raw)
            except InvalidHandle:  # a callback before this one has destroyed it
                continue
            if taken is not None:
                any_taken = True
                on_message(*taken)
        return any_taken

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
            message=printable(f"{topic}: {why}")[:_LONGEST_WARNING],
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
    known = [name for name in node._parameters if not name.startswith(_OF_RCLPY)]
    for name in node._parameter_overrides:
        known_elsewhere = name.startswith(_OF_RCLPY) or name in for_others()
        if name not in node._parameters and not known_elsewhere:
            raise BadInput(unknown_parameter(node.get_name(), name, known))
