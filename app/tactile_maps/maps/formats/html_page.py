"""Self-contained HTML pages in the style of all reports: light and dark, printable, without scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

_STYLE = """:root{color-scheme:light dark;--text:#222;--page:#fff;--line:#ddd;--note:#555}
@media(prefers-color-scheme:dark){:root{--text:#ddd;--page:#16191d;--line:#3a3f45;--note:#aaa}}
body{font:14px/1.5 sans-serif;max-width:1060px;margin:2em auto;padding:0 1em;color:var(--text);background:var(--page)}
h1{margin-bottom:0}h2{margin-top:2em}table{border-collapse:collapse;font-size:12px}
th,td{padding:2px 8px;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{position:sticky;top:0;background:var(--page)}td:first-child,th:first-child{text-align:left}
.table{max-height:32em;overflow:auto}svg{max-width:100%;height:auto}
tbody tr:hover td{background:var(--line)}.note{color:var(--note);max-width:60em}
@media print{:root{color-scheme:light;--text:#000;--page:#fff;--line:#ccc;--note:#444}body{margin:0;max-width:none}
.table{max-height:none;overflow:visible}th{position:static}h2{break-after:avoid}svg,tr{break-inside:avoid}}"""


def page_html(title: str, body: str, *, head: str = "") -> str:
    """Return a complete, self-contained page.

    Args:
        title: Heading.
        body: HTML.
        head: Additional HTML for the head element.
    """
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">{head}<title>{escape(title)}</title>'
        f"<style>{_STYLE}</style></head><body><h1>{escape(title)}</h1>{body}</body></html>\n"
    )


def facts_html(facts: Mapping[str, object]) -> str:
    """Return names and values as an HTML table."""
    rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in facts.items())
    return f"<table><tbody>{rows}</tbody></table>"


def rows_html(rows: Sequence[Mapping[str, object]]) -> str:
    """Return a table of rows with a header; the row under the pointer is highlighted."""
    return f'<div class="table">{_table(rows)}</div>'


def _table(rows: Sequence[Mapping[str, object]]) -> str:
    names = list(dict.fromkeys(key for row in rows for key in row))
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(row.get(name))}</td>' for name in names)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.5g}" if isinstance(value, float) else escape(str(value))
