"""Scenes of predictions, and of shapes with joints of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from kinmo.api.prediction import Prediction
from kinmo.core.mobility import Body, Mobility
from kinmo.core.overrides import FIXED
from kinmo.core.references import NUMBER_SIGN, body_labels
from kinmo.core.shape import Shape, bounds_of
from kinmo.core.shape_estimate import OVERRIDE, JointEstimate
from kinmo.core.wording import clean_text, counted
from kinmo.view.axis_words import joint_words
from kinmo.view.body_colors import body_colors
from kinmo.view.object_scene import ObjectScene, SceneBody, SceneOption


def scene_of(item: Prediction | Shape) -> ObjectScene:
    """The scene of a prediction, or of a shape with the joints of its annotation.

    Args:
        item: The prediction or the shape.

    Returns:
        The scene. Angles are in radians and lengths in the unit of the shape.
    """
    return _scene_of_shape(item) if isinstance(item, Shape) else _scene_of_prediction(item)


def with_options(scene: ObjectScene, index: int, options: Sequence[SceneOption]) -> ObjectScene:
    """The scene with other joints for one body. The first one is chosen.

    Args:
        scene: The scene.
        index: Index of the body.
        options: The joints, in the frame of the shape. Their labels are continued with words about the joint.
    """
    bodies = list(scene.bodies)
    body = Body(index, "", bodies[index].leaves)
    placed = []
    for option in options:
        found = _placed(option, scene, body)
        placed.append(replace(found, label=f"{option.label}: {found.label}"))
    bodies[index] = replace(bodies[index], options=tuple(placed), chosen=0)
    return replace(scene, bodies=tuple(bodies))


def _scene_of_shape(shape: Shape) -> ObjectScene:
    mobility = shape.mobility or Mobility((Body(0, "object", shape.leaves),))
    options = [(SceneOption("", body.joint),) if body.joint is not None else () for body in mobility.bodies]
    return _scene(shape, mobility, options, [0] * len(options), [None] * len(options), ())


def _scene_of_prediction(prediction: Prediction) -> ObjectScene:
    estimate = prediction.estimate
    before = estimate.predicted
    ranked = {body.id: ranks for body, ranks in zip(before.mobility.bodies, before.estimates, strict=True)}
    names = {body.id: body.name for body in before.mobility.bodies}
    clear = {number for number, label in body_labels(names).items() if label == names[number]}
    options, chosen, keys = [], [], []
    for body, estimates in zip(estimate.mobility.bodies, estimate.estimates, strict=True):
        own = [_option(each, rank) for rank, each in enumerate(ranked.get(body.id, ()), 1)]
        if estimates and estimates[0].source == OVERRIDE:
            own.insert(0, SceneOption("", body.joint, is_by_hand=True))
        options.append(tuple(own))
        chosen.append(_place_of(body, own))
        keys.append(None if body.id not in names else names[body.id] if body.id in clear else f"{NUMBER_SIGN}{body.id}")
    notes = () if estimate.correction is None else estimate.correction.notes
    return _scene(prediction.shape, estimate.mobility, options, chosen, keys, notes)


def _option(estimate: JointEstimate, rank: int) -> SceneOption:
    return SceneOption("", estimate.joint, estimate.score, rank)


def _place_of(body: Body, options: Sequence[SceneOption]) -> int:
    """Index of the option that is the present joint of a body: the first one that moves as it does."""
    same = (place for place, option in enumerate(options) if (option.joint is None) == (body.joint is None))
    return next(same, 0)


def _scene(
    shape: Shape,
    mobility: Mobility,
    options: Sequence[tuple[SceneOption, ...]],
    chosen: Sequence[int],
    keys: Sequence[str | None],
    notes: Iterable[str],
) -> ObjectScene:
    notes = (*notes, *shape.repairs, *(f"guessed: {guess}" for guess in shape.guesses.values()))
    scene = ObjectScene(shape.id, _facts(shape, mobility), shape, (), notes)
    labels = body_labels({body.id: body.name for body in mobility.bodies})
    colors = body_colors([body.joint is not None for body in mobility.bodies])
    bodies = []
    for index, body in enumerate(mobility.bodies):
        own = tuple(_placed(option, scene, body) for option in options[index])
        bodies.append(SceneBody(labels[body.id], body.parent, body.leaves, colors[index], own, chosen[index], keys[index]))
    return replace(scene, bodies=tuple(bodies))


def _placed(option: SceneOption, scene: ObjectScene, body: Body) -> SceneOption:
    """An option with its joint in the frame of the scene and a label."""
    joint = option.joint
    score = "" if option.probability is None else f" {option.probability:.2f}"
    rank = "" if option.rank is None else f"{option.rank}. "
    hand = ", by hand" if option.is_by_hand else ""
    if joint is None:
        return replace(option, label=f"{rank}{FIXED}{hand}{score}")
    shape = scene.shape
    leaves = body.leaves or shape.leaves
    words = joint_words(joint, bounds_of(shape.leaf_mesh(leaf) for leaf in leaves), shape.up, shape.front)
    limits = (None if end is None else end - joint.rest for end in (joint.lower, joint.upper))
    lower, upper = limits
    placed = replace(joint.rotated(scene.rotation), lower=lower, upper=upper, rest=0.0)
    return replace(option, joint=placed, label=f"{rank}{words}{hand}{score}")


def _facts(shape: Shape, mobility: Mobility) -> str:
    joints = sum(body.joint is not None for body in mobility.bodies)
    category = clean_text(shape.category)
    counts = [counted(len(shape.leaves), "part"), counted(joints, "joint")]
    return ", ".join([*([category] if category else []), *counts])
