"""From a picture to the blob that is the worm: background, illumination, debris, occlusion."""
