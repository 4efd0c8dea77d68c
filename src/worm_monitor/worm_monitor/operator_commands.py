"""What an operator may ask for on the page, as calls of the services that the nodes have."""

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.node import Node
from std_srvs.srv import Trigger

_TRACKER_NODE, _SOURCE_NODE, _RECORDER_NODE = "tracker", "image_source", "recorder"
LONGEST_NOTE = 400
_TRIGGERS = {
    "swap_head": f"{_TRACKER_NODE}/swap_head",
    "new_trial": f"{_SOURCE_NODE}/new_trial",
    "pause": f"{_SOURCE_NODE}/pause",
    "resume": f"{_SOURCE_NODE}/resume",
    "play_next": f"{_SOURCE_NODE}/play_next",
    "is_paused": f"{_SOURCE_NODE}/is_paused",
}


class OperatorCommands:
    """Does what browsers ask for; the answer comes as a remark.

    Parameters
    ----------
    node : rclpy.node.Node
        Calls the services.
    remark : callable
        Takes a line for people.
    replay : bool
        Whether a recording is shown; its notes are fixed, so that it can be stopped and go on.
    """

    def __init__(self, node: Node, remark: Callable[[str], None], *, replay: bool) -> None:
        self._remark = remark
        self._replay = replay
        self._playing = ""  # "paused", "playing", "seeking"; empty where it is not known
        self._asked = False
        self._triggers = {
            name: node.create_client(Trigger, service) for name, service in _TRIGGERS.items()
        }
        self._rate: float | str | None = None
        self._get_source = node.create_client(GetParameters, f"{_SOURCE_NODE}/get_parameters")
        self._set_source = node.create_client(SetParameters, f"{_SOURCE_NODE}/set_parameters")
        self._get_notes = node.create_client(GetParameters, f"{_RECORDER_NODE}/get_parameters")
        self._set_notes = node.create_client(SetParameters, f"{_RECORDER_NODE}/set_parameters")

    def offers(self) -> dict[str, Any]:
        """Return what can be asked for at this time, for the page."""
        plays = bool(self._triggers["pause"].service_is_ready())
        if plays and not self._asked:
            self._asked = True
            self._call("is_paused")
            if self._get_source.service_is_ready():
                self._get_source.call_async(
                    GetParameters.Request(names=["rate"])
                ).add_done_callback(self._take_rate)
        if self._playing == "seeking":  # it pauses by itself once it is there
            self._call("is_paused")
        return {
            "can_swap": bool(self._triggers["swap_head"].service_is_ready()),
            "can_pause": plays,
            "can_begin_anew": bool(self._triggers["new_trial"].service_is_ready()),
            "can_note": not self._replay and bool(self._set_notes.service_is_ready()),
            "paused": self._playing == "paused" if self._playing else None,
            "seeking": self._playing == "seeking",
            "rate": self._rate,
        }

    def obey(self, asked: dict[str, Any]) -> None:
        """Do what a browser asks for; what is none of these is passed over."""
        what, value = asked.get("do"), asked.get("value")
        if isinstance(what, str) and what in _TRIGGERS:
            self._call(what)
        elif what == "rate" and isinstance(value, int | float) and 0.0 <= value <= 100.0:
            self._set(self._set_source, "rate", float(value), f"rate {value:g}")
        elif what == "seek" and isinstance(value, int | float) and value >= 0.0:
            self._set(self._set_source, "seek_to", float(value), "")
        elif what == "note" and isinstance(value, str) and value.strip():
            self._note(" ".join(value.split())[:LONGEST_NOTE])

    def _call(self, name: str) -> None:
        client = self._triggers[name]
        if not client.service_is_ready():
            self._remark(f"{name.replace('_', ' ')}: nobody answers")
            return
        client.call_async(Trigger.Request()).add_done_callback(
            lambda future: self._take_answer(name, future.result())
        )

    def _take_answer(self, name: str, answer: Trigger.Response) -> None:
        if answer.message in ("paused", "playing", "seeking"):
            self._playing = answer.message
        elif name == "new_trial" or not answer.success:
            self._remark(f"{name.replace('_', ' ')}: {answer.message}")

    def _take_rate(self, future: Any) -> None:
        values = future.result().values
        if values and values[0].type == ParameterType.PARAMETER_DOUBLE:
            self._rate = values[0].double_value

    def _note(self, note: str) -> None:
        """Add a line to the trial's notes, which the recorder keeps in the results."""

        def add(future: Any) -> None:
            before = future.result().values[0].string_value
            notes = f"{before}\n{note}" if before else note
            self._set(self._set_notes, "notes", notes, f"noted: {note}")

        if self._get_notes.service_is_ready():
            self._get_notes.call_async(GetParameters.Request(names=["notes"])).add_done_callback(
                add
            )
        else:
            self._remark("nothing is recorded: the note is not kept")

    def _set(self, client: Any, name: str, value: float | str, said: str) -> None:
        if not client.service_is_ready():
            self._remark(f"no change of {name}: nobody answers")
            return
        if isinstance(value, str):
            kept = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
        else:
            kept = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        request = SetParameters.Request(parameters=[Parameter(name=name, value=kept)])

        def done(future: Any) -> None:
            result = future.result().results[0]
            if not result.successful:
                self._remark(f"refused: {result.reason}")
                return
            if name == "rate":
                self._rate = value
            elif name == "seek_to":
                self._playing = "seeking"
            if said:
                self._remark(said)

        client.call_async(request).add_done_callback(done)
