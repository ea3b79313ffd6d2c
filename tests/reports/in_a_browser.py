"""Tabs of Chromium, in which the tests of the page open reports."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page

from tests.reports.reported_results import reported_result

Open = Callable[..., Page]
RESULTS = [reported_result("thesis-24"), reported_result("thesis-06", {"exudyn": "failed"}, seed=5), reported_result("thesis-17", seed=9)]

#: A file, as reports are: after about:blank each report would be drawn by a new process of the browser.
EMPTY = Path(__file__).with_name("empty.html").as_uri()
#: Keeps what is on each canvas since it was cleared last: texts with their boxes in pixels of the page, places and colours of lines.
WATCHING = """(() => {
    const pen = CanvasRenderingContext2D.prototype, { clearRect, fillText, lineTo, stroke } = pen;
    const seen = window.seen = new Map(), nothing = () => ({ texts: [], points: [], colours: new Set() });
    const of = ({ canvas }) => seen.get(canvas) ?? seen.set(canvas, nothing()).get(canvas);
    pen.clearRect = function (...box) { seen.delete(this.canvas); clearRect.apply(this, box); };
    pen.fillText = function (text, x, y) {
        const box = this.measureText(text), side = (name) => box[`actualBoundingBox${name}`];
        of(this).texts.push([text, x - side("Left"), y - side("Ascent"), x + side("Right"), y + side("Descent")]);
        fillText.call(this, text, x, y);
    };
    pen.lineTo = function (x, y) { of(this).points.push([x, y]); lineTo.call(this, x, y); };
    pen.stroke = function () { of(this).colours.add(this.strokeStyle); stroke.call(this); };
})()"""


class Tabs:
    """The browser's tabs, which tests use one after the other: opening one takes as long as all else that a test does in it."""

    def __init__(self, browser: Browser) -> None:
        self.complaints: list[str] = []
        self._browser = browser
        self._free: dict[bool, list[Page]] = {True: [], False: []}
        self._taken: list[tuple[list[Page], Page]] = []

    def take(self, touched: bool, reduced_motion: Any, color_scheme: Any) -> Page:
        """A free one; `touched`: of a device with a touch screen."""
        free = self._free[touched]
        page = free.pop() if free else self._new(touched)
        page.emulate_media(reduced_motion=reduced_motion, color_scheme=color_scheme)
        self._taken.append((free, page))
        return page

    def _new(self, touched: bool) -> Page:
        page = self._browser.new_context(has_touch=touched).new_page()
        page.add_init_script(WATCHING)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", lambda message: self.complaints.append(message.text) if message.type == "error" else None)
        page.on("request", lambda request: self.complaints.append(request.url) if request.url.startswith("http") else None)
        return page

    def leave_all(self) -> list[str]:
        """Make all free for the next test; returns what the browser complained of."""
        for free, page in self._taken:
            page.goto(EMPTY)
            page.emulate_media(media="null")
            page.mouse.move(0, 0)
            free.append(page)
        self._taken.clear()
        complaints, self.complaints = self.complaints, []
        return complaints
