"""The rig as a camera sees it: a pinhole camera and rigid transforms, for viewers of all kinds.

A trial is calibrated by circles in the picture, one a chamber: nothing is known of the lens, nor
of how far away the camera is. Viewers ask for a camera all the same. It is one without distortion
whose axis meets the sheet at right angles in the middle of the picture, `NOMINAL_HEIGHT_M` above
chamber a. Any other height would show the same: only its ratio to the focal length is measured.
"""

from dataclasses import dataclass
from math import cos, sin

from worm_msgs_py.contract.chamber import Chamber, Geometry
from worm_msgs_py.contract.frames import CAMERA, RIG_FRAME

NOMINAL_HEIGHT_M = 1.0
"""Of the camera above chamber a; by convention, not by measurement."""


@dataclass(frozen=True, slots=True)
class Pinhole:
    """A camera without distortion and with square pixels.

    Attributes
    ----------
    width_px, height_px : int
        Size of the picture.
    focal_px : float
        Focal length; 0 where nothing is calibrated.
    centre_u_px, centre_v_px : float
        Where the optical axis meets the picture: its middle, whole numbers at pixel centres.
    """

    width_px: int
    height_px: int
    focal_px: float
    centre_u_px: float
    centre_v_px: float


@dataclass(frozen=True, slots=True)
class RigidTransform:
    """Where a frame lies in another one: a point p of `child` is rotation · p + translation.

    Attributes
    ----------
    parent, child : str
        Names of the frames.
    x_m, y_m, z_m : float
        The child's origin in the parent.
    quaternion : tuple of float
        x, y, z, w.
    """

    parent: str
    child: str
    x_m: float
    y_m: float
    z_m: float
    quaternion: tuple[float, float, float, float]


CAMERA_OVER_RIG = RigidTransform(
    CAMERA, RIG_FRAME, 0.0, 0.0, NOMINAL_HEIGHT_M, (1.0, 0.0, 0.0, 0.0)
)
"""The sheet in the camera's optical frame (x right, y down, z forward, REP 103): half a turn about
x, since the rig's y points up and its z at the camera."""


def pinhole(geometry: Geometry) -> Pinhole:
    """Return the camera that sees a rig; its focal length is 0 where there is no chamber.

    Pictures without a chamber may have a scale, but their worm lies in the camera's own frame at
    z = 0, which no camera sees: they have no focal length either.
    """
    width_px, height_px = geometry.picture_width_px, geometry.picture_height_px
    return Pinhole(
        width_px,
        height_px,
        geometry.chambers[0].px_per_m * NOMINAL_HEIGHT_M if geometry.chambers else 0.0,
        (width_px - 1) / 2,
        (height_px - 1) / 2,
    )


def chamber_transforms(geometry: Geometry) -> tuple[RigidTransform, ...]:
    """Return where each chamber's frame lies in the rig's.

    Each chamber stands at the height at which its plane is seen in its own scale, so that both
    chambers lie on the picture exactly though their scales differ by a fraction of a percent.
    """
    camera = pinhole(geometry)
    return tuple(_chamber_in_rig(chamber, camera) for chamber in geometry.chambers)


def _chamber_in_rig(chamber: Chamber, camera: Pinhole) -> RigidTransform:
    half = chamber.exit_rad / 2
    return RigidTransform(
        RIG_FRAME,
        chamber.name,
        x_m=(chamber.centre_u_px - camera.centre_u_px) / chamber.px_per_m,
        y_m=(camera.centre_v_px - chamber.centre_v_px) / chamber.px_per_m,
        z_m=NOMINAL_HEIGHT_M - camera.focal_px / chamber.px_per_m,
        quaternion=(0.0, 0.0, sin(half), cos(half)),
    )
