"""Serves the review page of one trial."""

import asyncio
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from aiohttp import web

import worm_monitor
from worm_monitor.access import Access
from worm_monitor.json_numbers import rounded
from worm_monitor.overlay_json import drawn_chambers
from worm_monitor.pictures import with_head
from worm_monitor.review.correction_store import CorrectionStore, who_am_i
from worm_monitor.review.events import reviewed_doubts, reviewed_events
from worm_monitor.review.pictures import TrialPictures
from worm_monitor.review.trial import plotted_columns
from worm_monitor.site import Site, page_files
from worm_msgs_py.contract.body import SURE_HEAD_CERTAINTY

_SHARED_PAGE = Path(worm_monitor.__file__).with_name("page")
_PAGE = Path(__file__).with_name("page")


class ReviewServer:
    """The page's server: it answers what the page asks for, and changes corrections alone.

    Parameters
    ----------
    pictures : TrialPictures
        Of the trial.
    access : Access
        Who may look.
    command : str
        How the trial is replayed with its corrections.
    stands_for : str
        What the words in it stand for that a person must put in.
    """

    def __init__(
        self,
        pictures: TrialPictures,
        access: Access,
        command: str,
        stands_for: str = "",
    ) -> None:
        self._pictures = pictures
        self._trial = pictures.trial
        self._corrections = CorrectionStore(self._trial)
        self._disk = ThreadPoolExecutor(1, thread_name_prefix="disk")
        curves = plotted_columns(self._trial)
        self._curves = b"".join(values.tobytes() for values in curves.values())
        self._about = json.dumps(self._told(list(curves), command, stands_for), allow_nan=False)
        routes = [
            web.get("/trial", self._tell),
            web.get("/columns", self._columns),
            web.get("/frame", self._frame),
            web.get("/corrections", self._show_corrections),
            web.post("/corrections", self._change_corrections),
        ]
        self.site = Site(access, page_files(_SHARED_PAGE, _PAGE), routes)

    async def close(self) -> None:
        """Answer no more."""
        await self.site.close()
        self._disk.shutdown(cancel_futures=True)
        self._pictures.close()

    def _told(self, names: list[str], command: str, stands_for: str) -> dict[str, Any]:
        trial = self._trial
        width, height = trial.size_px
        return {
            "name": trial.directory.absolute().name,
            "frames": len(trial.frames),
            "columns": names,
            "geometries": [
                {"size": [width, height], "chambers": drawn_chambers(rig)} for rig in trial.rigs
            ],
            "events": reviewed_events(trial.results),
            "doubtful": reviewed_doubts(trial.results),
            "applied": [
                [entry.first_frame, entry.last_frame]
                for entry in trial.results.corrections
                if entry.swaps(entry.first_frame)
            ],
            "sure": SURE_HEAD_CERTAINTY,
            "by": who_am_i(),
            "command": command,
            "stands_for": stands_for,
        }

    async def _tell(self, request: web.Request) -> web.StreamResponse:
        return web.Response(text=self._about, content_type="application/json")

    async def _columns(self, request: web.Request) -> web.StreamResponse:
        return web.Response(body=self._curves, content_type="application/octet-stream")

    async def _frame(self, request: web.Request) -> web.StreamResponse:
        """Answer with a frame's picture, and what is drawn over it."""
        asked = request.query.get("row", "")
        row = int(asked) if asked.isdecimal() and len(asked) < 12 else -1
        if not 0 <= row < len(self._trial.frames):
            return web.Response(status=404, text="no such frame")
        body = await self._from_disk(self._framed, row)
        return web.Response(body=body, content_type="application/octet-stream")

    def _framed(self, row: int) -> bytes:
        trial, tracks = self._trial, self._trial.results.tracks
        jpeg, scale, why_blank = self._pictures.jpeg(row)
        status = trial.status(row)
        told = {
            "row": row,
            "frame": int(trial.frames[row]),
            "t": rounded(float(trial.results.t_s[row]), 9),
            "scale": scale,
            "pose": trial.pose(row),
            "geometry": int(trial.rig_of[row]),
            "why_blank": why_blank,
            "status": status.label,
            "reason": status.reason,
            "has_pose": status.has_pose,
            "where": str(tracks["where"][row]),
        }
        return with_head(told, jpeg)

    async def _show_corrections(self, request: web.Request) -> web.StreamResponse:
        return web.json_response(await self._from_disk(self._corrections.told))

    async def _change_corrections(self, request: web.Request) -> web.StreamResponse:
        try:
            asked = await request.json()
        except ValueError:
            asked = None
        if not isinstance(asked, dict):
            return web.Response(status=400, text="no JSON object")
        return web.json_response(await self._from_disk(self._corrections.change, asked))

    async def _from_disk(self, call: Callable[..., Any], *of: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._disk, call, *of)
