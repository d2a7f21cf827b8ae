"""What the contacts panel offers, in words: ways to a force, thresholds, and what cannot be observed."""

from __future__ import annotations

from app.contacts.estimators.names import EstimatorName

ESTIMATORS: dict[EstimatorName, tuple[str, str]] = {
    "area-sum": (
        "Force: pressure times area",
        "Summed over the touched taxels and the ring around them. Costs nothing; totals stay within a few percent.\n"
        "Loses the shape: below a cover peaks come out too low and too wide.",
    ),
    "local-nnls": (
        "Force: pressures that only push",
        "Non-negative least squares on the region and its ring, with the cover's blur undone. 0.1 ms a contact.\n"
        "Tells the shape; noise may make the total some percent too large. Believes in the scene's depth of the cover.",
    ),
    "tikhonov": (
        "Force: as smooth as noise asks",
        "Tikhonov's least squares, with the price at which the answer explains the readings to within their noise.\n"
        "0.1 ms a contact. Tells the shape; pressures at the rim may come out negative.",
    ),
    "lumped": (
        "Force: sensor in the link",
        "What a force and torque sensor in each link would know without a skin, its weight taken off.\n"
        "0.2 ms a link. Feels friction, but sees several contacts of a link as one, between them, and no shape.",
    ),
}
"""Words and tool tip by name."""
ESTIMATOR_TIP = "Which way leads from the readings to a contact's force; control sees what it finds"
THRESHOLD_TIP = (
    "From which pressure on a taxel counts as touched; it stays so down to half of that.\n"
    "Automatic is 1\u2009kPa, or three standard deviations of the noise if that is more."
)
THRESHOLDS = (None, 500.0, 1000.0, 2000.0, 3000.0, 5000.0, 10000.0)
"""[Pa]; None is automatic."""
SHEAR = "Net shear cannot be observed"
SHEAR_TIP = (
    "These taxels feel normal stress. A sideways force on the cover presses on one side of itself and pulls on the\n"
    "other: what it makes taxels feel adds up to nothing (Cerruti's field has no mean). Any net shear could be added\n"
    "to a contact without a trace in the sum, so none is estimated. The true friction is only known to the simulation\n"
    "and to a force and torque sensor in the link."
)


def threshold_words(threshold: float | None, usual: float) -> str:
    """Like "Touched from 2 kPa"; ``usual`` is what automatic means now [Pa]."""
    if threshold is None:
        return f"Touched from {1e-3 * usual:.3g}\u2009kPa, automatic"
    return f"Touched from {1e-3 * threshold:.3g}\u2009kPa"
