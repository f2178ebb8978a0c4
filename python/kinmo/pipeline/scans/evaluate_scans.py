"""Errors of trained networks on the test scans of a category."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.evaluation.ancsh_protocol import score_as_ancsh
from kinmo.evaluation.scan_metrics import FrameScore, score_frame, truth
from kinmo.evaluation.scan_records import write_scores
from kinmo.pipeline.scans.scan_networks import PROTOCOLS, Cell, Protocol, pictures_path
from kinmo.pipeline.scans.scan_pictures import JudgedFrame, PictureBook, common_frames, write_pictures
from kinmo.pipeline.scans.scored_scans import JudgedScans
from kinmo.scans.ancsh.ancsh_predictor import Ancsh
from kinmo.scans.scan_file import ScanFile

SECONDS_PER_FRAME = 0.1


@dataclass(frozen=True)
class EvaluateScans:
    """Judge what the networks of a cell find in every test scan of their category, or in every one by the rough sensor."""

    workspace: Workspace
    cell: Cell
    device: str = "auto"
    on_rough: bool = False

    def plan(self) -> Plan:
        return Plan((), 0.0) if self._scans.held() else self.guess()

    def guess(self) -> Plan:
        """Judging all scans that there are."""
        files = self._scans.files()
        frames = sum(file.frames for file in files)
        each = seconds_per_unit(self.workspace, self._scans.stage, SECONDS_PER_FRAME, kind=self._scans.kind)
        return Plan(
            (f"judge {self._title} on {counted(frames, 'scan')} of {counted(len(files), 'test object')}",), frames * each
        )

    def run(self, observer: Observer) -> Outcome:
        path = self._scans.scores("kinmo")
        with self.workspace.locked():
            if self._scans.held():
                observer.note(f"{self._title}: judged already")
                return Outcome(path)
            weights = self.cell.weights(self.workspace)
            if weights is None:
                raise InputError(self.workspace.models, f"no networks for {self._title}: run kinmo train ancsh first")
            inputs, files = self._scans.inputs(), self._scans.files()
            self.workspace.forget(self._scans.stage)
            network = Ancsh.load(*weights, device=self.device)
            with timed(self.workspace, self._scans.stage) as watch:
                scores: dict[Protocol, list[tuple[str, FrameScore]]] = {protocol: [] for protocol in PROTOCOLS}
                book = None if self.on_rough else PictureBook(network.structure, common_frames(files))
                for done, file in enumerate(files, start=1):
                    for frame in judged(file, network, self.cell.seed):
                        if book is not None:
                            book.offer(frame)
                        scores["kinmo"].append((file.id, frame.score))
                        coded = score_as_ancsh(frame.found, frame.true, network.structure, frame.points, frame.said_parts)
                        scores["ancsh"].append((file.id, coded))
                    observer.progress(f"judging {self._title}", done, len(files), file.id)
                watch.amount = len(scores["kinmo"])
                watch.what = f"{counted(watch.amount, 'scan')} of {self.cell.category}"
            written = []
            if book is not None:
                written.append(pictures_path(self.workspace, self.cell))
                write_pictures(written[-1], book.pictures())
            for protocol, some in scores.items():
                written.append(self._scans.scores(protocol))
                write_scores(written[-1], some)
            outputs = tuple(str(each.relative_to(self.workspace.path)) for each in written)
            self.workspace.write_record(self._scans.stage, StageRecord(inputs, outputs))
        return Outcome(path)

    @property
    def _title(self) -> str:
        return self.cell.title(self.workspace)

    @property
    def _scans(self) -> JudgedScans:
        return JudgedScans(self.workspace, self.cell, self.on_rough)


def judged(file: ScanFile, network: Ancsh, seed: int) -> Iterator[JudgedFrame]:
    """Every frame of an object with what was found in it."""
    if file.structure != network.structure:
        raise InputError(file.path, f"has {file.structure.in_words}, expected {network.structure.in_words}")
    points, parts, poses, values, turns = (file.read(name) for name in ("points", "parts", "poses", "values", "turns"))
    answers, found = network.find(list(points), [1.0] * len(points), seed=seed)
    for row in range(len(points)):
        true = truth(poses[row], values[row], turns[row], file.joints, file.structure, file.extents)
        score = score_frame(found[row], true, file.structure)
        yield JudgedFrame(file.id, row, points[row], answers[row].parts, parts[row], found[row], true, score)
