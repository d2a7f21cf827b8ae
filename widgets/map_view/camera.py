"""The map's camera: what the viewport shows, as a frozen value without Qt. Zoom 1 frames the whole map."""

from __future__ import annotations

from dataclasses import dataclass, replace

MARGIN_PX = 36.0
LOWEST_ZOOM, HIGHEST_ZOOM = 0.5, 60.0

Point = tuple[float, float]


@dataclass(frozen=True)
class Camera:
    """Which scene point is at the viewport's centre, and how much larger than framed it is drawn.

    Because zoom is relative to the framing, a resized viewport keeps showing the same part of the map.

    Attributes:
        content: Width and height of what there is to see [scene units].
        centre: Scene point at the viewport's centre.
        zoom: 1 frames the whole content.
        origin: Upper left corner of the content [scene units].
    """

    content: Point
    centre: Point
    zoom: float = 1.0
    origin: Point = (0.0, 0.0)

    @classmethod
    def framing(cls, content: Point, origin: Point = (0.0, 0.0)) -> Camera:
        """The camera that frames all of ``content``."""
        return cls(content, (origin[0] + content[0] / 2, origin[1] + content[1] / 2), origin=origin)

    def over(self, content: Point, origin: Point, viewport: Point) -> Camera:
        """The same picture in a ``viewport``, of a content that is no longer what it was."""
        other = replace(self, content=content, origin=origin, zoom=1.0)
        return replace(other, zoom=self.scale(viewport) / other.scale(viewport))

    def scale(self, viewport: Point) -> float:
        """Pixels per scene unit in a ``viewport`` of this width and height [px]; the aspect is kept."""
        room = (max(viewport[0] - 2 * MARGIN_PX, 1.0), max(viewport[1] - 2 * MARGIN_PX, 1.0))
        return self.zoom * min(room[0] / max(self.content[0], 1e-9), room[1] / max(self.content[1], 1e-9))

    def to_scene(self, pixel: Point, viewport: Point) -> Point:
        """The scene point under a pixel."""
        scale = self.scale(viewport)
        return (
            self.centre[0] + (pixel[0] - viewport[0] / 2) / scale,
            self.centre[1] + (pixel[1] - viewport[1] / 2) / scale,
        )

    def zoomed(self, factor: float, pixel: Point, viewport: Point) -> Camera:
        """Zoom by ``factor`` so that the scene point under ``pixel`` stays there, as long as it lies on the map."""
        anchor = self.to_scene(pixel, viewport)
        zoom = min(max(self.zoom * factor, min(LOWEST_ZOOM, self.zoom)), max(HIGHEST_ZOOM, self.zoom))
        ratio = self.zoom / zoom
        moved = (
            anchor[0] + (self.centre[0] - anchor[0]) * ratio,
            anchor[1] + (self.centre[1] - anchor[1]) * ratio,
        )
        return self._looking_at(moved, zoom)

    def panned(self, dx: float, dy: float, viewport: Point) -> Camera:
        """Drag the map by this many pixels; the centre never leaves the map, so it cannot get lost."""
        scale = self.scale(viewport)
        return self._looking_at((self.centre[0] - dx / scale, self.centre[1] - dy / scale), self.zoom)

    def _looking_at(self, centre: Point, zoom: float) -> Camera:
        # An edit may have taken the map away from under the centre: it goes no farther out, and is not pulled back.
        low = [min(start, now) for start, now in zip(self.origin, self.centre, strict=True)]
        ends = [start + size for start, size in zip(self.origin, self.content, strict=True)]
        high = [max(end, now) for end, now in zip(ends, self.centre, strict=True)]
        x, y = (min(max(centre[k], low[k]), high[k]) for k in range(2))
        return replace(self, centre=(x, y), zoom=zoom)
