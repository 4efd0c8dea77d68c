"""Observables, quantities, C_θ(t) and distributions as standard messages."""

import array
from collections.abc import Sequence

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, MultiArrayLayout
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from worm_msgs_py.arrays import Floats, Integers
from worm_msgs_py.contract.analysis import Correlation, Distribution, Observables, Quantity
from worm_msgs_py.contract.frames import Where
from worm_msgs_py.convert.diagnostics import record_to_status, status_to_record
from worm_msgs_py.convert.joints import joints_from_msg, joints_to_msg
from worm_msgs_py.convert.message_checks import strict, whole
from worm_msgs_py.convert.stamp import (
    duration_to_seconds,
    header,
    seconds_to_duration,
    stamp_to_ns,
)

_REAL = (
    "r_h_m",
    "r_c_m",
    "r_t_m",
    "theta_h_rad",
    "psi_b_rad",
    "psi_h_rad",
    "theta_dot_rad_s",
    "v_b_m_s",
)
_CURVES = ("C_theta", "C_theta_error", "pairs", "C_theta_model")

_BIN = ("low", "high", "count")
_BEFORE = ("events_before", "summaries_before")


def observables_to_msg(observables: Observables, before: tuple[int, int] = (0, 0)) -> JointState:
    """Write one frame's observables; `contact` is 1, 0 or NaN where it cannot be told.

    `before` is how many messages the analysis has sent on `analysis/events` and on
    `analysis/summary` before this one: one who follows all three topics can put them in order,
    which DDS does not.
    """
    contact = observables.contact
    return joints_to_msg(
        {
            "frame": observables.frame,
            "where": observables.where,
            **{name: getattr(observables, name) for name in _REAL},
            "contact": float("nan") if contact is None else float(contact),
            **dict(zip(_BEFORE, before, strict=True)),
        },
        observables.stamp_ns,
        observables.where.label if observables.where is not Where.UNKNOWN else "",
    )


@strict
def observables_from_msg(msg: JointState) -> Observables:
    """Read one frame's observables; MalformedMessage where a name is missing."""
    values = joints_from_msg(msg)
    contact = values["contact"]
    return Observables(
        frame=whole(values["frame"]),
        stamp_ns=stamp_to_ns(msg.header.stamp),
        where=Where(whole(values["where"])),
        contact=None if contact != contact else bool(contact),
        **{name: values[name] for name in _REAL},
    )


@strict
def before_from_msg(msg: JointState) -> tuple[int, int]:
    """Read how many events and summaries the analysis sent before these observables."""
    values = joints_from_msg(msg)
    events, summaries = (whole(values[name]) for name in _BEFORE)
    return events, summaries


def quantities_to_msg(quantities: Sequence[Quantity], stamp_ns: int) -> DiagnosticArray:
    """Write estimates; a quantity without a value has level WARN and says why."""
    statuses = []
    for quantity in quantities:
        status = record_to_status(quantity.name, quantity.why, quantity)
        if quantity.value is None:
            status.level = DiagnosticStatus.WARN
        statuses.append(status)
    return DiagnosticArray(header=header(stamp_ns, ""), status=statuses)


@strict
def quantities_from_msg(msg: DiagnosticArray) -> tuple[Quantity, ...]:
    """Read estimates."""
    return tuple(status_to_record(status, Quantity) for status in msg.status)


def correlation_to_msg(correlation: Correlation, stamp_ns: int) -> JointTrajectory:
    """Write C_θ(t): a point a lag, `time_from_start` is the lag."""
    return JointTrajectory(
        header=header(stamp_ns, ""),
        joint_names=list(_CURVES),
        points=[
            JointTrajectoryPoint(
                positions=[float(value) for value in row],
                time_from_start=seconds_to_duration(lag),
            )
            for lag, *row in zip(
                correlation.lag_s,
                correlation.c,
                correlation.error,
                correlation.pairs,
                correlation.model,
                strict=True,
            )
        ],
    )


@strict
def correlation_from_msg(msg: JointTrajectory) -> Correlation:
    """Read C_θ(t); MalformedMessage where the message holds something else."""
    if list(msg.joint_names) != list(_CURVES):
        raise ValueError(f"expected the curves {_CURVES}, found {list(msg.joint_names)}")
    if any(len(point.positions) != len(_CURVES) for point in msg.points):
        raise ValueError("a point does not have a number for each curve")
    rows = np.array([list(point.positions) for point in msg.points]).reshape(-1, len(_CURVES))
    lags = [duration_to_seconds(point.time_from_start) for point in msg.points]
    c, error, pairs, model = (np.ascontiguousarray(column) for column in rows.T)
    return Correlation(
        lag_s=np.array(lags, dtype=np.float64),
        c=c,
        error=error,
        pairs=_counts(pairs),
        model=model,
    )


def distribution_to_msg(distribution: Distribution) -> Float64MultiArray:
    """Write a histogram: rows are lower edge, upper edge and count of each bin.

    The first dimension's label is ``name [unit]``, the second one's ``low,high,count``.
    """
    table = np.stack(
        [distribution.edges[:-1], distribution.edges[1:], distribution.counts], axis=1
    ).astype(np.float64)
    bins, columns = (int(size) for size in table.shape)
    return Float64MultiArray(
        layout=MultiArrayLayout(
            dim=[
                MultiArrayDimension(
                    label=f"{distribution.name} [{distribution.unit}]",
                    size=bins,
                    stride=bins * columns,
                ),
                MultiArrayDimension(label=",".join(_BIN), size=columns, stride=columns),
            ],
            data_offset=0,
        ),
        data=array.array("d", table.tobytes()),
    )


@strict
def distribution_from_msg(msg: Float64MultiArray) -> Distribution:
    """Read a histogram."""
    rows, columns = msg.layout.dim
    name, _, unit = rows.label.rstrip("]").rpartition(" [")
    table: Floats = np.array(msg.data, dtype=np.float64)
    if columns.size != len(_BIN) or columns.label != ",".join(_BIN) or not rows.size:
        raise ValueError("expected a row of low, high and count for each bin")
    table = table.reshape(rows.size, columns.size)
    return Distribution(
        name=str(name),
        unit=str(unit),
        edges=np.append(table[:, 0], table[-1:, 1]),
        counts=_counts(table[:, 2]),
    )


def _counts(values: Floats) -> Integers:
    """Return numbers that count something; ValueError where one cannot."""
    if not ((values >= 0.0) & (values <= 2.0**53)).all():
        raise ValueError("a count is negative, too large or no number")
    return values.astype(np.int64)


def sums_to_msg(name: str, sums: Floats) -> Float64MultiArray:
    """Write a sum: rows are blocks of time, the first dimension's label is its name."""
    blocks, columns = (int(size) for size in sums.shape)
    return Float64MultiArray(
        layout=MultiArrayLayout(
            dim=[
                MultiArrayDimension(label=name, size=blocks, stride=blocks * columns),
                MultiArrayDimension(label="sums", size=columns, stride=columns),
            ],
            data_offset=0,
        ),
        data=array.array("d", sums.astype(np.float64).tobytes()),
    )


@strict
def sums_from_msg(msg: Float64MultiArray) -> tuple[str, Floats]:
    """Read a sum and its name."""
    blocks, columns = msg.layout.dim
    return str(blocks.label), np.array(msg.data, dtype=np.float64).reshape(
        blocks.size, columns.size
    )
