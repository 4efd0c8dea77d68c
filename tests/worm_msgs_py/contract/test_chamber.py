"""The chamber's frame: x towards the exit, counter-clockwise as seen, exactly invertible."""

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worm_msgs_py import Chamber

angles = st.floats(-math.pi, math.pi)
pixels = st.floats(0, 4096)
chambers = st.builds(
    Chamber, st.just("chamber_a"), pixels, pixels, st.floats(50, 2000), angles, st.just(0.01)
)


@given(chambers, pixels, pixels)
def test_pixels_to_metres_and_back(chamber, u, v):
    back = chamber.to_pixels(*chamber.to_metres(u, v))
    assert back == pytest.approx((u, v), abs=1e-8)


@given(chambers)
def test_x_points_to_the_exit(chamber):
    u = chamber.centre_u_px + chamber.radius_px * math.cos(chamber.exit_rad)
    v = chamber.centre_v_px - chamber.radius_px * math.sin(chamber.exit_rad)
    assert chamber.to_metres(u, v) == pytest.approx((0.01, 0.0), abs=1e-12)


def test_up_in_the_picture_is_counter_clockwise_from_right():
    chamber = Chamber("chamber_a", 500, 500, 400, 0.0, 0.01)
    x, y = chamber.to_metres(500.0, 100.0)
    assert (x, y) == pytest.approx((0.0, 0.01))


@given(chambers, angles)
def test_yaw_turns_with_the_exit(chamber, direction):
    u = chamber.centre_u_px + 100 * math.cos(direction)
    v = chamber.centre_v_px - 100 * math.sin(direction)
    x, y = chamber.to_metres(u, v)
    yaw = chamber.yaw(direction)
    assert math.cos(math.atan2(y, x) - yaw) == pytest.approx(1.0)


def test_dataclasses_import_without_ros():
    program = (
        "import sys; sys.modules['rclpy'] = None; "
        "import worm_msgs_py, worm_msgs_py.topics; print('ok')"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "ok", done.stderr
