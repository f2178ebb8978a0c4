"""The figures printed in the paper agree with their printed means, and dashes are not counted as zeros."""

import pytest

from kinmo.evaluation.paper_tables import METHODS, mean, paper_tables, table1_figures, table1_means


def test_our_means_of_the_paper_do_not_count_its_dashes():
    by_method = dict(zip(METHODS, table1_means("distance"), strict=True))
    order = ("OBB_fine", "GNN_fine", "OBB_coarse", "GNN_coarse")
    assert [round(by_method[name], 4) for name in order] == [0.1319, 0.2408, 0.1275, 0.2586]


def test_the_printed_means_count_dashes_as_zeros_for_distances_only():
    printed = paper_tables()["table1"]["printed_mean"]
    distances = table1_figures("distance")
    for index in range(4):
        known = [row[index] for row in distances.values()]
        assert sum(value or 0.0 for value in known) / len(known) == pytest.approx(printed["distance"][index], abs=6e-4)
        assert table1_means("angle")[index] == pytest.approx(printed["angle"][index], abs=6e-3)
    assert sum(None in row for row in distances.values()) == 3


def test_the_printed_means_of_table_2_agree_with_its_rows():
    tables = paper_tables()["table2"]
    for method, printed in tables["printed_mean"].items():
        rows = [methods[method] for methods in tables["categories"].values()]
        for column, expected in enumerate(printed):
            values = [mean(row[column]) for row in rows if row[column]]
            tolerance = 0.03 if column in (0, 2, 3, 4) else 0.006
            assert sum(values) / len(values) == pytest.approx(expected, abs=tolerance)
