from __future__ import annotations

import re
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest
from config_page import reference_page

from kinmo.config import Config, builtin_configs, load_config
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import from_table, to_table

SMALL = (files("kinmo.config") / "builtin" / "small.toml").read_text(encoding="utf-8")
EPOCHS = next(line for line in SMALL.splitlines() if line.startswith("epochs"))


@pytest.mark.parametrize("name", builtin_configs())
def test_the_configurations_that_come_with_kinmo_survive_a_round_trip(name: str) -> None:
    config = load_config(name)
    assert from_table(Config, to_table(config), "test") == config


def test_the_papers_weights_and_threshold_are_the_papers() -> None:
    refinement = load_config("paper").refinement
    assert refinement.weights == (0.5, 0.3, 0.2, 0.0)
    assert refinement.threshold == refinement.least_score("paper") == 0.6
    assert refinement.least_score("kinmo") == refinement.chance


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("[gnn]", "[gnn]\ncolour = 1", "gnn.colour: unknown key"),
        ("[gnn]", "[gnn]\nchild_round = 1", r"gnn.child_round: unknown key \(did you mean child_rounds\?\)"),
        (EPOCHS, 'epochs = "many"', "gnn.training.epochs: expected int, got 'many'"),
        (EPOCHS, "epochs = true", "gnn.training.epochs: expected int, got True"),
        ('kind = "pointnet"', 'kind = "mine"', "gnn.leaf.kind: expected one of pointnet, dgcnn, got 'mine'"),
        ("widths = [32, 64, 128]", "widths = [32, 6.5]", r"gnn.leaf.widths\[1\]: expected int, got 6.5"),
        ("widths = [32, 64, 128]", "widths = 32", "gnn.leaf.widths: expected a list, got 32"),
        ("[gnn.leaf]", "[gnn.roots]", "gnn.roots: unknown key"),
        ("[axis.encoder]\nkind", "[axis.encoder]\nkinds", "axis.encoder.kinds: unknown key"),
        ("[gnn]", "[gnn", "expected TOML"),
    ],
)
def test_a_mistake_is_named_by_file_and_key(tmp_path: Path, before: str, after: str, message: str) -> None:
    assert before in SMALL
    path = tmp_path / "mine.toml"
    path.write_text(SMALL.replace(before, after, 1))
    with pytest.raises(InputError, match=f"mine.toml: {message}"):
        load_config(path)


def test_a_missing_section_is_named(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("")
    with pytest.raises(InputError, match=r'gnn: missing; .* begins with extends = "small"'):
        load_config(path)


def test_a_file_that_extends_another_says_only_what_differs(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "small"\n[ancsh]\nwidth = 0.25\n[ancsh.training]\nepochs = 3\n')
    small, mine = load_config("small"), load_config(path)
    training = replace(small.ancsh.training, epochs=3)
    assert mine == replace(small, ancsh=replace(small.ancsh, width=0.25, training=training))


def test_a_file_extends_one_that_extends_another(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "shipped"\n[ranking]\ndropout = 0.25\n')
    shipped = load_config("shipped")
    assert load_config(path) == replace(shipped, ranking=replace(shipped.ranking, dropout=0.25))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('extends = "smal"', "extends: 'smal', expected one of paper, shipped, small"),
        ("extends = 3", "extends: 3, expected one of paper, shipped, small"),
        ('extends = "small"\n[gnn]\ncolour = 1', "gnn.colour: unknown key"),
        ('extends = "small"\ngnn = 1', "gnn: expected a table"),
    ],
)
def test_a_mistake_in_a_file_that_extends_another_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=f"mine.toml: {message}"):
        load_config(path)


def test_an_absent_file_is_answered_with_the_known_names() -> None:
    with pytest.raises(InputError, match="expected a TOML file or one of paper, shipped, small"):
        load_config("huge")


@pytest.mark.parametrize(
    ("key", "value", "field"),
    [
        ("epochs", "0", "gnn.training.epochs"),
        ("learning_rate", "nan", "gnn.training.learning_rate"),
        ("learning_rate", "inf", "gnn.training.learning_rate"),
        ("widths", "[]", "gnn.leaf.widths"),
        ("widths", "[32, -64]", r"gnn.leaf.widths\[1\]"),
        ("head_dropout", "1.5", "axis.head_dropout"),
        ("centers", "[]", "ancsh.centers"),
        ("members", "0", "ranking.members"),
        ("epochs", "99999999999999999999", "gnn.training.epochs"),
        ("threads", "1000000", "gnn.training.threads"),
        ("states", "16\npoints = 1000000000", "scans.points"),
        ("states", "16\nsize = 1000000", "scans.size"),
    ],
)
def test_values_out_of_bounds_are_refused_by_name(key: str, value: str, field: str, tmp_path: Path) -> None:
    text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", SMALL, count=1, flags=re.MULTILINE)
    assert count == 1
    (tmp_path / "c.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=f"{field}: expected"):
        load_config(tmp_path / "c.toml")


def test_the_reference_page_is_up_to_date() -> None:
    page = Path(__file__).parents[1] / "docs" / "reference" / "config.md"
    assert page.read_text(encoding="utf-8") == reference_page()
