"""The stage that scores networks on the test scans of a category."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.evaluation.ancsh_protocol import score_as_ancsh
from kinmo.evaluation.scan_metrics import FrameScore, score_frame, true_scan_estimate
from kinmo.evaluation.scan_records import write_scores
from kinmo.pipeline.scans.scan_pictures import EvaluatedFrame, PictureBook, common_frames, write_pictures
from kinmo.pipeline.scans.scan_scores import PROTOCOLS, Protocol, ScanScores
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor
from kinmo.scans.files.scan_file import ScanFile

SECONDS_PER_FRAME = 0.1  # first estimate


@dataclass(frozen=True)
class EvaluateScans:
    """Score the networks of a run on every test scan of its category."""

    scores: ScanScores
    device: str = "auto"

    def plan(self) -> Plan:
        """Nothing, if the scores are up to date."""
        return Plan((), 0.0) if self.scores.current_inputs() else self.guess()

    def guess(self) -> Plan:
        """Estimate for scoring all present test scans."""
        files = self.scores.files()
        frames = sum(file.frames for file in files)
        own = self.scores
        each = seconds_per_unit(own.workspace, own.stage, SECONDS_PER_FRAME, prefix=own.prefix)
        step = f"evaluate {own.run} on {counted(frames, 'scan')} of {counted(len(files), 'test object')}"
        return Plan((step,), frames * each)

    def run(self, observer: Observer) -> Outcome:
        """Write the scores and the pictures."""
        own, workspace, run = self.scores, self.scores.workspace, self.scores.run
        with workspace.locked(), own.scanned.locked() if own.scanned else nullcontext():
            if own.current_inputs():
                observer.note(f"{run}: already evaluated")
                return Outcome(own.path("kinmo"))
            weights = run.weights(workspace)
            if weights is None:
                raise InputError(workspace.models, f"no networks for {run}: run kinmo train ancsh first")
            inputs, files = own.inputs(), own.files()
            workspace.forget(own.stage)
            network = AncshPredictor.load(*weights, device=self.device)
            scores: dict[Protocol, list[tuple[str, FrameScore]]] = {protocol: [] for protocol in PROTOCOLS}
            structure = network.structure
            book = None if own.title else PictureBook(structure, common_frames(files))
            with timed(workspace, own.stage) as watch:
                for done, file in enumerate(files, start=1):
                    for frame in evaluated_frames(file, network, run.seed):
                        if book is not None:
                            book.offer(frame)
                        scores["kinmo"].append((file.id, frame.score))
                        as_coded = score_as_ancsh(frame.found, frame.true, structure, frame.points, frame.predicted_parts)
                        scores["ancsh"].append((file.id, as_coded))
                    observer.progress(f"evaluating {run}", done, len(files), file.id)
                watch.amount = len(scores["kinmo"])
                watch.what = f"{counted(watch.amount, 'scan')} of {run.category}"
            if book is not None:
                write_pictures(own.pictures, book.pictures())
            for protocol in PROTOCOLS:
                write_scores(own.path(protocol), scores[protocol])
            written = [*([own.pictures] if book else []), *map(own.path, PROTOCOLS)]
            workspace.record(own.stage, inputs, written)
        return Outcome(own.path("kinmo"))


def evaluated_frames(file: ScanFile, network: AncshPredictor, seed: int) -> Iterator[EvaluatedFrame]:
    """Every frame of an object with the prediction, the truth and the score."""
    if file.structure != network.structure:
        raise InputError(file.path, f"has {file.structure.in_words}, expected {network.structure.in_words}")
    points, parts, poses, values, turns = (file.read(name) for name in ("points", "parts", "poses", "values", "turns"))
    predictions, found = network.predict(list(points), [1.0] * len(points), seed=seed)
    for row in range(len(points)):
        true = true_scan_estimate(poses[row], values[row], turns[row], file.joints, file.structure, file.extents)
        score = score_frame(found[row], true, file.structure)
        yield EvaluatedFrame(file.id, row, points[row], predictions[row].parts, parts[row], found[row], true, score)
