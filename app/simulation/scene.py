"""A scene: which robot in which skin, what is simulated, and what a scripted hand does before a person comes."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.errors import SceneError
from app.simulation.effects import Effects
from app.simulation.stimuli import Stroke
from app.skin.cover_spec import CoverSpec


@dataclass(frozen=True)
class Scene:
    """Everything a session starts from.

    Attributes:
        name: Short, as on the command line.
        title: For people.
        robot: A robot's name or file.
        cover: How the skin places itself.
        taxel_file: An iCub positions file whose taxels are worn instead of a cover; empty for none.
        effects: What is simulated.
        control: Settings of the controller that differ from its defaults, by name.
        strokes: What the scripted hand does.
        tick: Seconds between two control ticks, a whole number of time steps.
        seed: Of all randomness in the session.

    Raises:
        SceneError: Time step, tick or a seed is out of range.
    """

    name: str
    robot: str
    title: str = ""
    cover: CoverSpec = field(default_factory=CoverSpec)
    taxel_file: str = ""
    effects: Effects = field(default_factory=Effects)
    control: dict[str, str | float] = field(default_factory=dict)
    strokes: tuple[Stroke, ...] = ()
    tick: float = 0.005
    seed: int = 0

    def __post_init__(self) -> None:
        if not 1e-5 <= self.effects.timestep <= 0.02:
            raise SceneError(
                "that time step cannot be simulated",
                file=self.name,
                place="effects.timestep",
                value=self.effects.timestep,
                remedy="Choose 0.00001 to 0.02 s",
            )
        steps = self.tick / self.effects.timestep
        if not (1e-4 <= self.tick <= 1.0 and abs(steps - round(steps)) < 1e-6):
            raise SceneError(
                "a tick must be a whole number of time steps",
                file=self.name,
                place="tick",
                value=f"{self.tick} s",
                remedy=f"Choose a multiple of {self.effects.timestep} s up to 1 s",
            )
        for place, seed in (("seed", self.seed), ("cover.seed", self.cover.seed)):
            if seed < 0:
                raise SceneError("a seed cannot be negative", file=self.name, place=place, value=seed)

    @property
    def steps_per_tick(self) -> int:
        """Physics steps in one control tick."""
        return round(self.tick / self.effects.timestep)


@dataclass(frozen=True)
class EffectRow:
    """One effect of a scene: whether it is on, and why, in words for a person."""

    name: str
    on: bool
    why: str


def effect_rows(scene: Scene) -> tuple[EffectRow, ...]:
    """What a scene simulates, what not, and why, in words for a person."""
    effects = scene.effects
    gravity = {
        "off": "the scene asks for none",
        "on": "the scene asks for weight without compensation",
        "compensated": "the arm carries its own weight, as a torque-controlled arm does",
    }[effects.gravity]
    contact = "links feel each other" if effects.contact == "self" else "only fingers touch in this scene"
    return (
        EffectRow("gravity", effects.gravity != "off", gravity),
        EffectRow("fingers", True, "pokes by hand or script"),
        EffectRow("contact between links", effects.contact == "self", contact),
        EffectRow("joint limits", effects.joint_limits, "the arm can reach them" if effects.joint_limits else "off"),
        EffectRow("skin pressure (water-fill)", True, "the map shows pressure"),
    )
