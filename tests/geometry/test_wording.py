from kinmo.core.wording import counted


def test_one_thing_has_no_s():
    assert [counted(count, "object") for count in (0, 1, 2)] == ["0 objects", "1 object", "2 objects"]
