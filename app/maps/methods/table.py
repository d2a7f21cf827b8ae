"""The methods by name, and what each is for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from app.arrays import FloatArray
from app.errors import MapError
from app.maps.methods import arap, balanced, harmonic, lscm, slim, tutte, unroll
from app.maps.methods.disk import Disk


@dataclass(frozen=True)
class Method:
    """One way of laying a disk flat.

    Attributes:
        name: As the user writes it.
        title: What it keeps, in a few words.
        run: Yields ever better planes (k, 2) of a disk for a place of the slider between angles (0) and lengths (1).
        lengths: What our own minimiser keeps instead where the method's map is not one-to-one: 1 lengths, 0 angles.
        slides: Whether the slider does anything.
    """

    name: str
    title: str
    run: Callable[[Disk, float], Iterator[FloatArray]]
    lengths: float = 1.0
    slides: bool = False


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method(
            "symmetric-dirichlet",
            "angles and lengths in balance; always valid",
            lambda disk, lengths: balanced.flatten_disk(disk, lengths=lengths),
            slides=True,
        ),
        Method("tutte", "nothing but validity", lambda disk, _: tutte.flatten_disk(disk.positions, disk.faces)),
        Method("harmonic", "smoothness, border on a circle", lambda disk, _: harmonic.flatten_disk(disk), lengths=0.0),
        Method("lscm", "angles", lambda disk, _: lscm.flatten_disk(disk), lengths=0.0),
        Method("arap", "lengths, by rigid triangles", lambda disk, _: arap.flatten_disk(disk)),
        Method("slim", "angles and lengths in balance, by libigl", lambda disk, _: slim.flatten_disk(disk)),
        Method("unroll", "planes, cylinders and cones, exactly", lambda disk, _: unroll.flatten_disk(disk)),
    )
}


def find_method(name: str) -> Method:
    """The method called ``name``.

    Raises:
        MapError: There is none.
    """
    if name not in METHODS:
        raise MapError(
            "there is no such method", place="method", value=name, remedy=f"Choose one of: {', '.join(METHODS)}"
        )
    return METHODS[name]
