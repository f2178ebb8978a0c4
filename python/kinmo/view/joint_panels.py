"""The controls of a viser page: one folder per joint, corrections, and what belongs to the whole object."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from kinmo.core.errors import KinmoError
from kinmo.core.joint import KIND_WORDS, JointKind
from kinmo.core.overrides import FIXED, TYPES
from kinmo.pipeline.joint_lines import UNCERTAIN
from kinmo.view.object_scene import SceneBody
from kinmo.view.scene_building import scene_of

if TYPE_CHECKING:
    from kinmo.view.viser_server import ObjectServer

MAX_OPEN = 6
"""Largest number of joints whose folders are open at the start."""
STEPS = 200
"""Steps of a slider."""
DIGITS = 4
"""Digits of the width of a range."""
SECONDS = 4.0
"""Time in which an animation opens and closes a joint."""
FRAMES_PER_SECOND = 30


class JointPanels:
    """All controls of a page."""

    def __init__(self, page: ObjectServer) -> None:
        self.page = page
        self.gui = page.server.gui
        self._lock = threading.RLock()  # viser calls in several threads
        self._own = threading.local()  # `is_filling` while this thread sets values, and not a person
        self._player: threading.Thread | None = None
        self._build()

    def _build(self) -> None:
        page, gui = self.page, self.gui
        gui.configure_theme(control_layout="floating", control_width="medium", show_logo=False, show_share_button=False)
        self.facts = gui.add_markdown(f"**{_escaped(page.scene.name)}**  \n{_escaped(page.scene.facts)}")
        buttons = gui.add_button_group("Move", ("Play all", "Reset"))
        buttons.on_click(lambda _: self.play() if buttons.value == "Play all" else self.reset())
        axes = gui.add_checkbox("Axes", True)
        axes.on_update(lambda _: page.set_axes(axes.value))
        if page.scene.has_looks:
            looks = gui.add_checkbox("Textures", False, hint="Materials of the file")
            looks.on_update(lambda _: page.set_looks(looks.value))
        self.rows: dict[int, JointRow] = {}
        shown = [index for index, body in enumerate(page.scene.bodies) if any(option.joint for option in body.options)]
        for index in shown:
            self.rows[index] = JointRow(self, index, is_open=len(shown) <= MAX_OPEN)
        if page.corrections is not None:
            can_save = page.corrections.folder is not None
            save = gui.add_button("Save corrections", disabled=not can_save, hint="Writes overrides.toml beside joints.json")
            save.on_click(lambda _: self.attempt(self.save))
        self.status = gui.add_markdown("")
        if page.scene.notes:
            with gui.add_folder("Notes", expand_by_default=False):
                gui.add_markdown("\n".join(f"- {_escaped(note)}" for note in page.scene.notes))

    def attempt(self, action: Callable[[], str | None]) -> None:
        """Do something, and show its message or its error."""
        try:
            message = action()
        except KinmoError as error:
            message = f"**Not possible:** {_escaped(str(error))}"
        except OSError as error:
            message = f"**Not possible:** {_escaped(str(error.strerror or error))}"
        self.status.content = message or ""

    def correct(self, action: Callable[[], None]) -> None:
        """Change the corrections, and show the corrected joints. A wrong change is taken back."""
        corrections = self.page.corrections
        if self.is_filling or corrections is None:
            return

        def change() -> str:
            before = corrections.prediction, corrections.table
            try:
                action()
            except KinmoError:
                corrections.prediction, corrections.table = before  # of several changes, the first may have been right
                raise
            self.page.correct(scene_of(corrections.prediction))
            return "Not saved yet: press *Save corrections*." if corrections.folder else "Corrected."

        with self._lock:
            self.attempt(change)
            self.fill()

    def fill(self) -> None:
        """Show the present state in all controls."""
        with self.filling():
            for row in self.rows.values():
                row.fill()

    @contextmanager
    def filling(self) -> Iterator[None]:
        """While values that this thread sets are not those of a person."""
        before = self.is_filling
        self._own.is_filling = True
        try:
            yield
        finally:
            self._own.is_filling = before

    def reset(self) -> None:
        """Move all joints to the pose of the file."""
        self._player = None
        for row in self.rows.values():
            row.move(0.0)

    def play(self) -> None:
        """Move all joints through their ranges and back."""
        if self._player is not None and self._player.is_alive():
            self._player = None
            return
        self._player = threading.Thread(target=self._animate, daemon=True)
        self._player.start()

    def _animate(self) -> None:
        me, begin = threading.current_thread(), time.monotonic()
        while self._player is me and (now := time.monotonic() - begin) < SECONDS:
            share = 0.5 - 0.5 * math.cos(2.0 * math.pi * now / SECONDS)
            for index, value in self.page.scene.opened(share).items():
                if index in self.rows:
                    self.rows[index].move(value)
            time.sleep(1.0 / FRAMES_PER_SECOND)
        if self._player is me:
            for row in self.rows.values():
                row.move(0.0)

    def save(self) -> str:
        """Write overrides.toml. Returns a line about it."""
        assert self.page.corrections is not None
        with self._lock:
            return _escaped(self.page.corrections.save())

    @property
    def is_filling(self) -> bool:
        """True while this thread sets values."""
        return getattr(self._own, "is_filling", False)


class JointRow:
    """The controls of one joint."""

    def __init__(self, panels: JointPanels, index: int, *, is_open: bool) -> None:
        self.panels, self.page, self.index = panels, panels.page, index
        gui = panels.gui
        self.folder = gui.add_folder(_title(self.body), expand_by_default=is_open)
        with self.folder:
            self.slider = gui.add_slider(self._label, 0.0, 1.0, 0.01, 0.0)
            self.slider.on_update(lambda _: self._moved())
            labels = [option.label for option in self.body.options]
            self.choice = gui.add_dropdown("joint", labels, initial_value=labels[self.body.chosen], hint="Ranked joints")
            self.choice.on_update(lambda _: self.chosen())
            if self.body.key is not None and self.page.corrections is not None:
                self._add_corrections()
        with panels.filling():
            self.fill()

    def _add_corrections(self) -> None:
        gui, key, corrections = self.panels.gui, str(self.body.key), self.page.corrections
        assert corrections is not None
        correct = self.panels.correct
        with gui.add_folder("Correct", expand_by_default=False):
            self.name = gui.add_text("name", self.body.name)
            self.type = gui.add_dropdown("type", TYPES, initial_value=self._type)
            self.range = gui.add_vector2("range", (0.0, 1.0), step=0.001)
            apply = gui.add_button("Apply name, type and range")
            flip = gui.add_button("Open the other way")
            reset = gui.add_button("As predicted", hint="Takes back the corrections of the joint and the name")
        apply.on_click(lambda _: correct(self.apply))
        flip.on_click(lambda _: correct(lambda: corrections.flip(key)))
        reset.on_click(lambda _: correct(self.reset))

    @property
    def body(self) -> SceneBody:
        return self.page.scene.bodies[self.index]

    @property
    def _type(self) -> str:
        return FIXED if self.body.joint is None else KIND_WORDS[self.body.joint.kind]

    @property
    def _label(self) -> str:
        return "angle (°)" if self._type == KIND_WORDS[JointKind.REVOLUTE] else f"slide ({self.page.scene.unit})"

    @property
    def _factor(self) -> float:
        """Shown value of one radian or length."""
        joint = self.body.joint
        return 180.0 / math.pi if joint is not None and joint.kind is JointKind.REVOLUTE else 1.0

    def fill(self) -> None:
        """Show the present joint."""
        body, corrections = self.body, self.page.corrections
        self.folder.label = _title(body)
        labels = tuple(option.label for option in body.options)
        if tuple(self.choice.options) != labels:
            self.choice.options = labels
        self.choice.value = labels[body.chosen]
        self.slider.label, self.slider.disabled = self._label, body.joint is None
        if body.joint is not None:
            lower, upper = (self._factor * end for end in self.page.scene.range_of(self.index))
            self.slider.min, self.slider.max, self.slider.step = lower, upper, (upper - lower) / STEPS
            self.slider.value = self._factor * self.page.values.get(self.index, 0.0)
        if body.key is None or corrections is None:
            return
        self.name.value, self.type.value = body.name, self._type
        if body.joint is not None and body.joint.lower is not None:
            lower, upper = (self._factor * end for end in self.page.scene.range_of(self.index))
            decimals = min(max(DIGITS - math.ceil(math.log10(upper - lower)), 0), 9) if upper > lower else DIGITS
            self.range.precision, self.range.step = decimals, 10.0**-decimals
            self.range.value = (round(lower, decimals), round(upper, decimals))
        else:
            self.range.value = (0.0, 0.0)
        self._shown_range = self.range.value

    def move(self, value: float) -> None:
        """Move the joint to a value, in radians or lengths."""
        if self.body.joint is not None:
            self.slider.value = self._factor * value

    def reset(self) -> None:
        """Take back the corrections of the joint and the name."""
        if self.page.corrections is not None:
            self.page.corrections.reset(str(self.body.key))

    def _moved(self) -> None:
        if not self.panels.is_filling and self.body.joint is not None:
            self.page.set_value(self.index, float(self.slider.value) / self._factor)

    def chosen(self) -> None:
        """Take the joint that the menu shows."""
        if self.panels.is_filling:
            return
        option = next(each for each in self.body.options if each.label == self.choice.value)
        key, corrections, rank = self.body.key, self.page.corrections, option.rank
        if key is not None and corrections is not None and rank is not None:
            self.panels.correct(lambda: corrections.choose(key, rank))

    def apply(self) -> None:
        """Take the name, the type and the range of the fields."""
        corrections, key = self.page.corrections, str(self.body.key)
        assert corrections is not None
        kind = self.type.value
        if kind != self._type:
            corrections.set_type(key, kind)
        lower, upper = self.range.value
        if kind != FIXED and (lower, upper) not in (self._shown_range, (0.0, 0.0)):
            corrections.set_range(key, float(lower), float(upper))
        if self.name.value != self.body.name:
            corrections.set_name(key, self.name.value)


def _title(body: SceneBody) -> str:
    """Name, kind and probability of a joint."""
    option, joint = body.option, body.joint
    kind = FIXED if joint is None else KIND_WORDS[joint.kind]
    if option is None or option.probability is None:
        return f"{body.name}: {kind}{', by hand' if option is not None and option.is_by_hand else ''}"
    doubt = ", uncertain" if option.probability < UNCERTAIN else ""
    return f"{body.name}: {kind}, {option.probability:.0%}{doubt}"


def _escaped(text: str) -> str:
    """Text without a meaning in Markdown."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]<>#+!|~" else c for c in text)
