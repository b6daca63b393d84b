"""Results with a page."""

from __future__ import annotations

from typing import Any


class Report(dict[str, Any]):
    """Dict of a result that shows its page in a notebook; the page is the value of `page`."""

    def _repr_html_(self) -> str:
        return self["page"]._repr_html_()
