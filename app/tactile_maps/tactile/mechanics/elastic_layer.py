"""Material and stiffness of the skin's cover."""

from __future__ import annotations

from dataclasses import dataclass

from tactile_maps.core.errors import SimulationError, check_range


@dataclass(frozen=True)
class ElasticLayer:
    """The soft cover on the rigid shell of a link.

    Attributes:
        stiffness: Stiffness of one contact with a body [N/m], in any posture.
        modulus: Young's modulus of the material [Pa].
        poisson: Poisson ratio, below 0.5: an incompressible layer is not a foundation of independent springs.
        thickness: Thickness of the compliant layer [m].
        depth: Depth of the taxels below the outer surface [m].
        friction: Default Coulomb coefficient against skin, links and objects.

    Raises:
        SimulationError: A number is out of its range.
    """

    stiffness: float = 2e4
    modulus: float = 1e5
    poisson: float = 0.25
    thickness: float = 0.004
    depth: float = 0.002
    friction: float = 0.5

    def __post_init__(self) -> None:
        ranges = (
            ("stiffness", 1.0, 1e8),
            ("modulus", 1e2, 1e10),
            ("poisson", 0.0, 0.49),
            ("thickness", 1e-5, 0.1),
            ("depth", 1e-5, 0.1),
            ("friction", 0.0, 5.0),
        )
        for name, low, high in ranges:
            what = f"the {name} of the layer"
            check_range(what, getattr(self, name), low, high, error=SimulationError, place=f"layer.{name}")

    @property
    def foundation(self) -> float:
        """Stiffness per area of the layer as a bed of springs [Pa/m].

        K = E (1 - nu) / ((1 + nu) (1 - 2 nu) h), a thin layer bonded to a rigid shell (Johnson, Contact Mechanics, 4.3
        and 5.8). The default, a foam of 0.1 MPa and 4 mm, gives 3e7 Pa/m.
        """
        nu = self.poisson
        return self.modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * self.thickness)

    @property
    def shear_foundation(self) -> float:
        """Tangential stiffness per area of the layer as a bed of springs [Pa/m]: the shear modulus over the thickness.

        It is (1 - 2 nu) / (2 (1 - nu)) of ``foundation``, by default a third.
        """
        return self.modulus / (2 * (1 + self.poisson) * self.thickness)
