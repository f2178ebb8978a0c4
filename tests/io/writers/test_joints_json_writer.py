"""joints.json: writer, reader and schema agree."""

import copy
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from articulated import articulated_shapes, shape_of_boxes
from exports import write_joints_json
from hypothesis import given, settings

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape_estimate import JointEstimate, PredictionProvenance, ShapeEstimate
from kinmo.io.readers.joints_json_reader import read_joints_json
from kinmo.io.writers import ExportOptions, write_formats
from kinmo.io.writers.joints_json_writer import joints_document
from kinmo.pipeline.joint_lines import joint_lines
from kinmo.robot.physics import Physics

SCHEMA = json.loads((files("kinmo.io.writers") / "joints.schema.json").read_text(encoding="utf-8"))
TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "integer": int,
    "number": (int, float),
    "null": type(None),
}


def violations(value, rule, root, path="$"):
    """Violations of a JSON Schema by `value`. Supports the part of JSON Schema that the file uses."""
    if "$ref" in rule:
        yield from violations(value, root["$defs"][rule["$ref"].rsplit("/", 1)[1]], root, path)
    if "anyOf" in rule and all(list(violations(value, option, root, path)) for option in rule["anyOf"]):
        yield f"{path}: no option fits"
    if "const" in rule and value != rule["const"]:
        yield f"{path}: not {rule['const']}"
    if "enum" in rule and value not in rule["enum"]:
        yield f"{path}: {value} unknown"
    names = rule.get("type", [])
    names = [names] if isinstance(names, str) else names
    if names and not any(isinstance(value, TYPES[n]) and (n == "boolean" or not isinstance(value, bool)) for n in names):
        yield f"{path}: not {names}"
        return
    if isinstance(value, dict):
        yield from (f"{path}: lacks {key}" for key in rule.get("required", []) if key not in value)
        extra = rule.get("additionalProperties", True)
        for key, item in value.items():
            inside = rule.get("properties", {}).get(key, extra)
            if inside is False:
                yield f"{path}: has {key}"
            elif isinstance(inside, dict):
                yield from violations(item, inside, root, f"{path}.{key}")
    if isinstance(value, list):
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", np.inf):
            yield f"{path}: {len(value)} items"
        for index, item in enumerate(value):
            yield from violations(item, rule.get("items", {}), root, f"{path}[{index}]")


def prediction_of(shape):
    estimates = tuple(
        (
            JointEstimate(body.joint, MotionType.R_V_S if body.joint else MotionType.FIXED, 0.75, {"feasibility": 0.5}, "edge"),
            JointEstimate(None, CoarseType.NONE, 0.1),
        )
        for body in shape.mobility.bodies
    )
    return ShapeEstimate(shape.id, shape.category, shape.mobility, estimates, tuple(ranked[1] for ranked in estimates), "kinmo")


def plain_shape():
    return shape_of_boxes([((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 2, 1))], (Body(0, "a", (1,)), Body(1, "b", (2,))))


PROVENANCE = PredictionProvenance("sha256:0123", {"tau": 0.6, "candidates": "all"})
OPTIONS = ExportOptions(provenance=PROVENANCE)


def plain(value):
    """Nested dataclasses, arrays and enums as plain data that can be compared."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return repr(value)


@settings(max_examples=25)
@given(articulated_shapes())
def test_a_prediction_survives_a_round_trip(tmp_path_factory, shape):
    prediction = prediction_of(shape)
    path = write_joints_json(shape, prediction, tmp_path_factory.mktemp("out"), ExportOptions(provenance=PROVENANCE))
    found, provenance = read_joints_json(path, shape)
    assert plain(found) == plain(prediction)
    assert provenance == PROVENANCE
    assert [p.name for p in path.parent.iterdir()] == ["joints.json"]


@settings(max_examples=25)
@given(articulated_shapes())
def test_the_file_conforms_to_its_schema(shape):
    physics = Physics(density=600.0, part_densities={"door": 20.0}, friction=0.5)
    for options in (OPTIONS, replace(OPTIONS, package="cabinet", physics=physics)):
        document = json.loads(json.dumps(joints_document(shape, prediction_of(shape), options)))
        assert list(violations(document, SCHEMA, SCHEMA)) == []


@settings(max_examples=25)
@given(articulated_shapes())
def test_links_and_joints_are_those_of_the_urdf_and_the_other_way_round(tmp_path_factory, shape):
    prediction, folder = prediction_of(shape), tmp_path_factory.mktemp("out")
    written = write_formats(shape, prediction, folder, ["urdf", "joints_json"], ExportOptions(collision="none"))
    bodies = json.loads(written["joints_json"].read_text(encoding="utf-8"))["bodies"]
    robot = ET.parse(written["urdf"]).getroot()
    slides = [(body["slide_link"], body["slide_joint_name"]) for body in bodies if "slide_link" in body]
    links = {body["link"] for body in bodies} | {link for link, _ in slides}
    joints = [body["joint_name"] for body in bodies if body["joint_name"] is not None] + [joint for _, joint in slides]
    assert sorted(link.get("name") for link in robot.iter("link")) == sorted(links)
    assert sorted(joint.get("name") for joint in robot.iter("joint")) == sorted(joints)
    ends = {joint.get("name"): joint.find("child").get("link") for joint in robot.iter("joint")}
    places = {visual.get("name"): link.get("name") for link in robot.iter("link") for visual in link.iter("visual")}
    for body in bodies:
        assert (body["joint_name"] is None) == (body["joint"] is None)
        assert body["joint"] is None or ends[body["joint_name"]] == body["link"]
        assert ("slide_link" in body) == (body["joint"] is not None and body["joint"]["kind"] == "PR")
        for part in body["parts"]:
            assert places[part["name"].replace(" ", "_")] == body["link"]


def test_unnamed_bodies_have_the_number_of_the_summary_in_their_links():
    joint = Joint(JointKind.PRISMATIC, np.array([0.0, 0, 1]), np.zeros(3), 0.0, 1.0)
    names = ["base", "", "", "引き出し箱", "Tür links", "door"]
    bodies = [Body(i, name, (i + 1,), 0 if i else None, joint if i else None) for i, name in enumerate(names)]
    shape = shape_of_boxes([((0, i, 0), (1, i + 1, 1)) for i in range(len(names))], bodies)
    document = json.loads(json.dumps(joints_document(shape, prediction_of(shape), OPTIONS)))
    links = [body["link"] for body in document["bodies"]]
    assert links == ["base", "body_1", "body_2", "body_3", "Tur_links", "door"]
    assert [line.strip().split(":")[0] for line in joint_lines(document)] == [
        "#1 (link body_1)",
        "#2 (link body_2)",
        "引き出し箱 (link body_3)",
        "Tür links (link Tur_links)",
        "door",
    ]


def test_a_file_without_names_of_links_is_read(tmp_path):
    shape = plain_shape()
    document = joints_document(shape, prediction_of(shape), OPTIONS)
    for body in document["bodies"]:
        del body["link"], body["joint_name"]
    assert list(violations(json.loads(json.dumps(document)), SCHEMA, SCHEMA)) == []
    (tmp_path / "joints.json").write_text(json.dumps(document))
    found, _ = read_joints_json(tmp_path / "joints.json", shape)
    assert plain(found) == plain(prediction_of(shape))
    assert joint_lines(document) == []


def test_only_bodies_of_junk_alone_are_junk():
    boxes = [((0, i, 0), (1, i + 1, 1)) for i in range(3)]
    bodies = (Body(0, "base", ()), Body(1, "dirt", (1,)), Body(2, "door", (2, 3)))
    shape = shape_of_boxes(boxes, bodies, junk=frozenset({1, 2}))
    document = joints_document(shape, prediction_of(shape), OPTIONS)
    assert [body["is_junk"] for body in document["bodies"]] == [False, True, False]


def changed(document, path, value):
    document = copy.deepcopy(document)
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return document


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("schema_version",), 2),
        (("shape", "id"), "another"),
        (("bodies", 0, "parts", 0, "id"), 999),
        (("bodies", 0, "parent"), 17),
        (("bodies", 0, "parent"), 0),
        (("bodies", 0, "parts"), []),
        (("bodies", 0, "estimates", 0, "type"), "R_X"),
        (("bodies", 0, "estimates", 0, "score"), "high"),
        (("bodies", 0, "network", "terms"), None),
        (("bodies", 0, "joint"), {"kind": "R", "direction": [0, 0, 2], "pivot": [0, 0, 0]}),
        (("bodies", 0, "joint"), {"kind": "R", "direction": [0, 0, 1], "pivot": [0, 0, 0], "lower": 1.0, "upper": 0.0}),
        (("bodies", 0, "joint"), {"kind": "R", "direction": [0, 0, 1], "pivot": [0, 0, 0], "upper": 1.0}),
        (("config",), []),
    ],
)
def test_a_wrong_file_is_an_error_with_its_field(tmp_path, path, value):
    shape = plain_shape()
    document = json.loads(json.dumps(joints_document(shape, prediction_of(shape), OPTIONS)))
    file = tmp_path / "joints.json"
    file.write_text(json.dumps(changed(document, path, value)))
    with pytest.raises(InputError, match=r"joints\.json: \w+"):
        read_joints_json(file, shape)


def test_the_schema_detects_wrong_values():
    shape = plain_shape()
    document = json.loads(json.dumps(joints_document(shape, prediction_of(shape), OPTIONS)))
    for path, value in (
        (("bodies", 0, "extra"), 1),
        (("shape", "up"), [0, 1]),
        (("bodies", 0, "estimates", 0, "type"), "R_X"),
        (("weights",), 3),
    ):
        assert list(violations(changed(document, path, value), SCHEMA, SCHEMA))


def test_a_mobility_without_scores_cannot_be_written(tmp_path):
    shape = plain_shape()
    with pytest.raises(InputError, match=r"joints\.json: holds a prediction"):
        write_joints_json(shape, shape.mobility, tmp_path)
