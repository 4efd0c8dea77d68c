"""What values are possible at all, by quantity: a walk through a summary that finds the others."""

from math import inf, isfinite

RADIUS_MM = 10.0
BETWEEN_0_AND_1 = {
    "contact_fraction", "reversal_per_cycle", "search_bridged", "search_missing",
    "frames_untracked", "frames_uncertain", "success",
}  # fmt: skip
CORRELATIONS = {"theta_dot_psi_b_correlation", "theta_dot_incidence_correlation"}
SIGNED = {"v_w", "v_b_mean"}
OF_FRAMES = ("r_h", "r_c", "r_t", "psi_b", "contact_fraction", "frames_", "l_w", "d_w")


def limits(name, unit, radius_mm=RADIUS_MM):
    """Return the least and the most that a quantity can be, in its unit."""
    is_part = name in BETWEEN_0_AND_1 or name.startswith("failures_") or "_over_R" in name
    if is_part or name.endswith("_exponential_p"):
        return 0.0, 1.0
    if name in CORRELATIONS:
        return -1.0, 1.0
    if name in {"c_theta_start", "c_theta_tail"}:
        return -2.0, 2.0
    if unit == "deg":
        low = 0.0 if name == "psi_b_positive_peak" else -180.0
        return low, 0.0 if name == "psi_b_negative_peak" else 180.0
    if name in {"delta_r_h", "delta_r_h_mean", "radius_noise"}:
        return 0.0, radius_mm
    return (-inf, inf) if name in SIGNED else (0.0, inf)


def impossible(summary):
    """Return what cannot be in a summary, a line each; an empty list where all is possible.

    Parameters
    ----------
    summary : dict
        As `summary.json` has it.
    """
    radii = [one["radius_mm"] for one in (summary.get("geometry") or {}).values()]
    read = (summary.get("frames") or {}).get("read", inf)
    found = []
    for name, entry in summary["quantities"].items():
        least, most = limits(name, entry["unit"], max(radii, default=RADIUS_MM))
        value, low, high, n = (entry.get(key) for key in ("value", "low", "high", "n"))
        found += [
            f"{name}: {key} {number} is not within {least} … {most} {entry['unit']}"
            for key, number in (("value", value), ("low", low), ("high", high))
            if number is not None and not (isfinite(number) and least <= number <= most)
        ]
        if value is None and not entry.get("why"):
            found.append(f"{name}: no value and no reason")
        if value is None and (low is not None or high is not None):
            found.append(f"{name}: an interval without a value")
        if value is not None and not (low is None or low <= value):
            found.append(f"{name}: {value} is below its interval from {low}")
        if value is not None and not (high is None or value <= high):
            found.append(f"{name}: {value} is above its interval to {high}")
        if least == 0.0 and most == inf and value and high is not None and high > 1e4 * value:
            found.append(f"{name}: {value} with an interval to {high}, which bounds nothing")
        if not (isinstance(n, int) and n >= 0):
            found.append(f"{name}: n = {n}")
        elif name.startswith(OF_FRAMES) and n > read:
            found.append(f"{name}: n = {n} of {read} frames")
    return found + _of_curve(summary.get("correlation"))


def _of_curve(curve):
    """Return what cannot be in C_θ: beyond ±1, errors below 0, pairs that are no counts."""
    if not curve:
        return []
    found = [f"C_θ = {c}" for c in curve["c"] if c is not None and not abs(c) <= 1]
    found += [f"error of C_θ {e}" for e in curve["error"] if e is not None and not e >= 0]
    return found + [f"{pairs} pairs" for pairs in curve["pairs"] if pairs < 0]


def impossible_in_tracks(columns):
    """Return what cannot be in a table of frames, given as arrays by name."""
    ranges = {
        "r_h_mm": (0.0, inf), "r_c_mm": (0.0, inf), "r_t_mm": (0.0, inf),
        "psi_b_deg": (-180.0, 180.0), "psi_h_deg": (-180.0, 180.0), "contact": (0.0, 1.0),
        "head_certainty": (0.5, 1.0), "confidence": (0.0, 1.0), "length_mm": (0.0, inf),
        "width_mm": (0.0, inf), "length_px": (0.0, inf), "width_px": (0.0, inf),
    }  # fmt: skip
    return [
        f"{name}: {value}"
        for name, (least, most) in ranges.items()
        for value in columns[name]
        if value is not None and value == value and not least <= value <= most
    ]
