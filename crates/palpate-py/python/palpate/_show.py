"""The report where someone looks: in a notebook, or in a browser."""

from __future__ import annotations

import html
import sys
import tempfile
import webbrowser
from pathlib import Path


def show_page(page: str, height: int) -> None:
    """Show a page in the notebook that calls, `height` pixels high, or in a browser; see `Result.show`."""
    if "ipykernel" in sys.modules:
        from IPython.display import display

        # A frame of its own keeps styles and scripts of the page and of the notebook apart.
        frame = f'<iframe srcdoc="{html.escape(page)}" width="100%" height="{height}" style="border: 0"></iframe>'
        display({"text/html": frame, "text/plain": "the report"}, raw=True)  # type: ignore[no-untyped-call]
        return
    # The browser reads it later: the folder of temporary files is where it may stay.
    with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="palpate-", encoding="utf-8", delete=False) as file:
        file.write(page)
    if not webbrowser.open(Path(file.name).as_uri()):
        print(f"no browser was found; the report is {file.name}")
