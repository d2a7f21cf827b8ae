"""Single-page reports of commands that measure or describe, in the style of the studies' reports."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from tactile_maps.cli.shared.output import plain_text
from tactile_maps.core.errors import ExportError
from tactile_maps.core.files import write_atomically
from tactile_maps.maps.formats.html_page import facts_html, page_html, rows_html
from tactile_maps.studies.base.figures import BarChart
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.study.report import describe_machine, figure_html


def write_fact_page(
    path: str | Path,
    title: str,
    facts: Mapping[str, object],
    *,
    tables: Mapping[str, Sequence[Row]] | None = None,
    charts: Sequence[BarChart] = (),
    pictures: Mapping[str, bytes] | None = None,
) -> Path:
    """Write one self-contained HTML page.

    Args:
        path: The file; an existing one is replaced.
        title: Heading.
        facts: Facts by name; empty ones are left out.
        tables: Rows by heading; tables without rows are left out.
        charts: Diagrams.
        pictures: PNG files by heading, which the page contains.

    Returns:
        The file.

    Raises:
        ExportError: It cannot be written.
    """
    body = facts_html({name: plain_text(value) for name, value in facts.items() if value not in (None, "", [], {})})
    body += "".join(map(figure_html, charts))
    body += "".join(f"<h2>{escape(name)}</h2>{_picture_html(name, png)}" for name, png in (pictures or {}).items())
    body += "".join(f"<h2>{escape(heading)}</h2>{rows_html(rows)}" for heading, rows in (tables or {}).items() if rows)
    body += f"<h2>Made on</h2>{facts_html(describe_machine())}"
    write_atomically(Path(path), page_html(title, body).encode(), error=ExportError)
    return Path(path)


def _picture_html(name: str, png: bytes) -> str:
    data = base64.b64encode(png).decode()
    return f'<img alt="{escape(name)}" style="max-width:100%" src="data:image/png;base64,{data}">'
