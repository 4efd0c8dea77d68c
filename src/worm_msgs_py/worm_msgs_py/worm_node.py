"""The base of all our nodes: endpoints without what costs time and nobody needs."""

from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node


class WormNode(Node):
    """A node whose endpoints have no handlers of QoS events, and which has no parameter services.

    rclpy gives each publisher and subscription two handlers by default, which warn of a partner
    with another QoS. The executor builds all of them into every wait: with forty endpoints whose
    two sides are both ours that was a third of the graph's time. Where the partner is not ours,
    ask for the warning with ``event_callbacks=SubscriptionEventCallbacks()``.
    """

    def __init__(self, name: str, **node_arguments: Any) -> None:
        super().__init__(name, start_parameter_services=False, **node_arguments)

    def read_parameter(self, name: str, default: Any, description: str) -> Any:
        """Declare a parameter that is read once, with what it is for; return its value.

        `default` may be a `rclpy.parameter.Parameter.Type` where there is no sensible one.
        """
        descriptor = ParameterDescriptor(description=description, read_only=True)
        return self.declare_parameter(name, default, descriptor).value

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
