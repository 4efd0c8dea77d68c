"""What bodies are compared with: the object of a detection, its dark places, marks and dirt."""

from worm_tracker.detection.detection import Detection
from worm_tracker.detection.dirt import specks
from worm_tracker.midline.body_model import BodyModel
from worm_tracker.midline.body_residual import ObjectMasks, dark_places
from worm_tracker.midline.body_shade import ShadedObject
from worm_tracker.propagation.overlaps import overlaps_tell
from worm_tracker.propagation.propagation_settings import PropagationSettings


def object_in(detection: Detection, model: BodyModel, settings: PropagationSettings) -> ObjectMasks:
    """Return the object of a detection in its window, and what shows how a worm lies in it."""
    dark = None
    if overlaps_tell(model, settings):
        level = model.level * detection.gain / model.gain
        dark = dark_places(detection.view.found_in, level, model.darkening, settings.residual)
    shade = model.shade_at(detection.gain) if model.is_marked else None
    smooth = detection.view.smooth
    shaded = None if shade is None else ShadedObject(smooth, shade, model.darkening)
    dirt, most_px2 = detection.dirt_in_window, settings.most_speck_widths2 * model.width**2
    dirt = None if dirt is None else specks(dirt, most_px2)
    mask = detection.object_pixels()
    return ObjectMasks(mask, dark, model.width, settings.residual, shaded, dirt)
