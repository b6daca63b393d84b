"""Bar of `progress=True`."""

from __future__ import annotations


class Bar:
    """Bar of tqdm, in a terminal or a notebook: the share that is done, or the step and the time passed where no share is known."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError as error:
            raise ImportError(
                "progress=True: found no tqdm, expected it installed (pip install 'ballrace[progress]'), or a callable"
            ) from error
        self._tqdm = tqdm
        self._bar = None
        self._is_share = None

    def __call__(self, done: float | None, text: str) -> None:
        is_share = done is not None
        if self._bar is None or is_share != self._is_share:
            self._begin(is_share, text)
        self._bar.set_description_str(text, refresh=False)
        if is_share:
            self._bar.n = min(done, 1.0)
        self._bar.refresh()

    def _begin(self, is_share: bool, text: str) -> None:
        self.close(False)
        form = "{desc}: {percentage:3.0f}% |{bar}| {elapsed} ({remaining} left)" if is_share else "{desc} ({elapsed})"
        self._bar = self._tqdm(desc=text, total=1.0 if is_share else None, bar_format=form)
        self._is_share = is_share

    def close(self, is_done: bool) -> None:
        """Ends the bar; full if the work is done."""
        if self._bar is None:
            return
        if is_done and self._is_share:
            self._bar.n = 1.0
            self._bar.refresh()
        self._bar.close()
        self._bar = None
