"""Predictions of trained ANCSH networks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from tiny_ancsh import TINY, frame_with_differing_axes

from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.learning.weights import save_weights
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, PartNetwork, PartOutput
from kinmo.scans.ancsh.ancsh_predictor import AncshPredictor, npcs_to_naocs
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.preprocessing.input_frame import base_axes, manhattan_axes


def test_predictions_do_not_depend_on_the_scale_of_a_scan(file: ScanFile) -> None:
    torch.manual_seed(0)
    parts = file.structure.part_count
    network = AncshNetwork(TINY, parts, parts).eval()
    networks = AncshPredictor(network, network, TINY, file.structure, CategoryPrior.uninformative(file.structure), "cpu")
    points = file.read("points", 0).astype(np.float64)
    here, there = (networks.predict_points([cloud])[0] for cloud in (points, 1e5 * points))
    np.testing.assert_allclose(here.npcs, there.npcs, atol=5e-3)
    np.testing.assert_allclose(here.frame.rotation, there.frame.rotation, atol=1e-3)


def test_predictions_do_not_depend_on_the_distance_from_the_camera(file: ScanFile) -> None:
    torch.manual_seed(0)
    parts = file.structure.part_count
    network = AncshNetwork(TINY, parts, parts).eval()
    networks = AncshPredictor(network, network, TINY, file.structure, CategoryPrior.uninformative(file.structure), "cpu")
    points = file.read("points", 0).astype(np.float64)
    here, there = (networks.predict_points([cloud])[0] for cloud in (points, points + 3.0 * points.mean(axis=0)))
    np.testing.assert_allclose(here.npcs, there.npcs, atol=5e-3)
    np.testing.assert_allclose(here.frame.rotation, there.frame.rotation, atol=1e-3)


def test_the_map_from_npcs_to_naocs_comes_from_all_points_of_a_part() -> None:
    rng = np.random.default_rng(0)
    npcs, scales, shifts = rng.uniform(0.1, 0.9, (90, 3, 3)), np.array([0.9, 0.5, 0.2]), rng.uniform(-0.3, 0.5, (3, 3))
    parts = np.repeat([0, 1], 45)  # the last part has no points
    naocs = scales[:, None] * npcs + shifts
    found = npcs_to_naocs(npcs, naocs, parts)
    np.testing.assert_allclose(found[0], scales, rtol=1e-9)
    np.testing.assert_allclose(found[1], shifts, atol=1e-9)


def test_the_second_pass_uses_the_axes_of_the_predicted_base(file: ScanFile, monkeypatch: pytest.MonkeyPatch) -> None:
    row, count = frame_with_differing_axes(file), file.structure.part_count
    network = AncshNetwork(TINY, count, count).eval()
    points, parts = file.read("points", row), file.read("parts", row)
    known = torch.nn.functional.one_hot(torch.from_numpy(parts.astype(np.int64)), count)[None]
    output = PartOutput(known, torch.zeros(1, len(parts), count, 3))
    monkeypatch.setattr(PartNetwork, "forward", lambda self, seen: output)
    networks = AncshPredictor(network, network, TINY, file.structure, CategoryPrior.uninformative(file.structure), "cpu")
    rotation = networks.predict_points([points])[0].frame.rotation
    first = manhattan_axes(points[None])
    np.testing.assert_allclose(rotation, base_axes(points[None], parts[None] == 0, first)[0])
    assert np.abs(rotation - first[0]).max() > 0.1


def test_no_scans_give_no_predictions(file: ScanFile) -> None:
    count = file.structure.part_count
    network = AncshNetwork(TINY, count, count).eval()
    assert (
        AncshPredictor(
            network, network, TINY, file.structure, CategoryPrior.uninformative(file.structure), "cpu"
        ).predict_points([])
        == []
    )


@pytest.mark.parametrize("classes", [None, "two", 0, 10**9])
def test_weights_without_a_valid_number_of_classes_are_rejected_in_one_line(
    file: ScanFile, tmp_path: Path, classes: object
) -> None:
    count, structure = file.structure.part_count, file.structure
    facts = {"kinds": [kind.value for kind in structure.kinds], "parents": list(structure.parents)}
    facts["category_prior"] = CategoryPrior.uninformative(structure).to_data()
    whole, other, broken = (tmp_path / f"{name}.safetensors" for name in ("whole", "other", "broken"))
    network, parts = AncshNetwork(TINY, count, count), PartNetwork(TINY, count, count)
    save_weights(whole, network, KIND, to_table(TINY), facts | {"classes": count})
    save_weights(other, parts, KIND, to_table(TINY), facts | {"classes": count})
    save_weights(broken, network, KIND, to_table(TINY), facts if classes is None else facts | {"classes": classes})
    for paths in ((broken, other), (whole, broken)):
        with pytest.raises(InputError, match=rf"broken\.json: facts\.classes: expected {count} or {count + 1}, got"):
            AncshPredictor.load(*paths, "cpu")
    AncshPredictor.load(whole, other, "cpu")
