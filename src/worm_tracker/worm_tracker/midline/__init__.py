"""From a blob to a midline with its tips: contours, edges, body fits, and the learned body."""
