"""The colours of head, centroid, tail, midline, wall and exit, in every figure and over pictures.

Of Okabe and Ito's set, which the colour-blind can tell apart; head, centroid and tail are blue, red
and green as in the paper.
"""

HEAD_COLOUR, CENTROID_COLOUR, TAIL_COLOUR = "#0072B2", "#D55E00", "#009E73"
WALL_COLOUR, EXIT_COLOUR, MIDLINE_COLOUR = "#E69F00", "#CC79A7", "#F0E442"
