"""Camera and transforms, in OpenCV's hands, lay chambers on the picture where pixels say."""

from dataclasses import replace
from math import pi

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform as Pose
from scipy.spatial.transform import Rotation

from worm_model.simulator.rig import Rig
from worm_msgs_py.contract.camera_view import (
    CAMERA_OVER_RIG,
    NOMINAL_HEIGHT_M,
    chamber_transforms,
    pinhole,
)
from worm_msgs_py.contract.chamber import Chamber, Geometry

reals = st.floats(-3.0, 3.0, allow_nan=False)


def chambers(name):
    return st.builds(
        Chamber,
        name=st.just(name),
        centre_u_px=st.floats(-500.0, 2500.0),
        centre_v_px=st.floats(-500.0, 1500.0),
        radius_px=st.floats(20.0, 900.0),
        exit_rad=st.floats(-7.0, 7.0),
        radius_m=st.floats(1e-3, 0.1),
    )


def pose(transform):
    return Pose.from_components(
        (transform.x_m, transform.y_m, transform.z_m), Rotation.from_quat(transform.quaternion)
    )


def projected(geometry, which, points_m):
    """Project points of a chamber's plane, shape (n, 2), as any vision software does."""
    camera = pinhole(geometry)
    to_camera = pose(CAMERA_OVER_RIG) * pose(chamber_transforms(geometry)[which])
    inside = to_camera.apply(np.column_stack([points_m, np.zeros(len(points_m))]))
    matrix = np.array(
        [
            [camera.focal_px, 0, camera.centre_u_px],
            [0, camera.focal_px, camera.centre_v_px],
            [0, 0, 1],
        ]
    )
    inside = np.ascontiguousarray(inside)[:, None]
    return cv2.projectPoints(inside, np.zeros(3), np.zeros(3), matrix, None)[0][:, 0]


@given(
    a=chambers("chamber_a"),
    b=chambers("chamber_b"),
    points=st.lists(st.tuples(reals, reals), min_size=1, max_size=8),
)
def test_every_point_of_both_chambers_is_seen_where_its_pixel_is(a, b, points):
    b = replace(b, radius_px=a.radius_px * b.radius_m / a.radius_m * 1.004)  # one sheet, two fits
    geometry = Geometry(1, 0, 1280, 448, (a, b))
    for which, chamber in enumerate((a, b)):
        points_m = np.array(points) * chamber.radius_m
        expected = np.stack(chamber.to_pixels(*points_m.T), axis=1)
        seen = projected(geometry, which, points_m)
        assert seen == pytest.approx(expected, abs=1e-3 * 1e-3 * chamber.radius_px + 1e-6)


def test_what_lies_right_and_up_in_the_picture_is_right_and_up_in_the_rig():
    right_of_middle_and_above = Chamber("chamber_a", 511.5 + 200.0, 511.5 - 100.0, 400.0, 0.0, 0.01)
    (place,) = chamber_transforms(Geometry(1, 0, 1024, 1024, (right_of_middle_and_above,)))
    assert (place.x_m, place.y_m, place.z_m) == pytest.approx((0.005, 0.0025, 0.0))


def test_z_of_a_chamber_points_at_the_camera_which_stands_at_its_height():
    geometry = Rig(exit_rad=1.1).geometry()
    to_camera = pose(CAMERA_OVER_RIG) * pose(chamber_transforms(geometry)[0])
    assert to_camera.rotation.apply((0.0, 0.0, 1.0)) == pytest.approx((0.0, 0.0, -1.0))
    assert to_camera.apply((0.0, 0.0, 0.0))[2] == pytest.approx(NOMINAL_HEIGHT_M)


def test_a_mirrored_picture_turns_the_exit_and_not_the_hand():
    """In a mirror too y grows counter-clockwise as seen, so frames stay right-handed."""
    geometry = Rig(exit_rad=0.4).geometry()
    (chamber,) = geometry.chambers
    u = geometry.picture_width_px - 1 - chamber.centre_u_px
    mirrored = replace(chamber, centre_u_px=u, exit_rad=pi - chamber.exit_rad)
    seen = projected(replace(geometry, chambers=(mirrored,)), 0, np.array([[0.01, 0.0]]))
    exit_u, exit_v = chamber.to_pixels(0.01, 0.0)
    assert seen[0] == pytest.approx((geometry.picture_width_px - 1 - exit_u, exit_v))
    rotation = pose(chamber_transforms(replace(geometry, chambers=(mirrored,)))[0]).rotation
    assert np.linalg.det(rotation.as_matrix()) == pytest.approx(1.0)


def test_the_scale_of_chamber_a_is_the_focal_length_and_its_height_is_the_nominal_one():
    geometry = Rig(chamber_b=True, px_per_mm=16.0).geometry()
    assert pinhole(geometry).focal_px == pytest.approx(16.0e3 * NOMINAL_HEIGHT_M)
    assert [item.child for item in chamber_transforms(geometry)] == ["chamber_a", "chamber_b"]
    assert pinhole(geometry).centre_u_px == 511.5


def test_without_a_chamber_there_is_no_focal_length_and_no_transform():
    bare = Geometry(1, 0, 640, 480)
    assert pinhole(bare).focal_px == 0.0
    assert chamber_transforms(bare) == ()
