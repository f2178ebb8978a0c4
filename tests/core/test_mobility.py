"""Trees of bodies."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.mobility import Body, Mobility, descendants, has_cycle, path_to_root


@given(st.lists(st.one_of(st.none(), st.integers(0, 7)), min_size=8, max_size=8))
def test_a_cycle_is_found_if_a_node_is_its_own_ancestor(parents: list[int | None]) -> None:
    def returns_to_itself(start: int) -> bool:
        node: int | None = start
        for _ in range(len(parents) + 1):
            if node is None:
                return False
            node = parents[node]
        return True

    assert has_cycle(parents) == any(returns_to_itself(i) for i in range(len(parents)))
    if not has_cycle(parents):
        for root in (i for i, parent in enumerate(parents) if parent is None):
            assert descendants(parents, root)[0] == root


def test_the_path_to_the_root_begins_with_the_node_itself() -> None:
    assert list(path_to_root({3: 1, 1: 0, 2: 0}, 3)) == [3, 1, 0]


def test_a_body_is_junk_if_all_its_leaves_are() -> None:
    bodies = (Body(0, "empty", ()), Body(1, "dirt", (1,)), Body(2, "door", (2, 3)))
    mobility = Mobility(bodies, junk=frozenset({1, 2}))
    assert [mobility.is_junk(index) for index in range(3)] == [False, True, False]
