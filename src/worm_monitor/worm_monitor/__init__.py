"""The page on which a lab watches a trial: picture, plots, numbers and controls in a browser."""
